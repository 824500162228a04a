"""The messages of a scene as dicts: proto/scene.proto says what each field means.

Written by python/write_fields.py."""

from __future__ import annotations

from typing import Any, Literal, Sequence, TypedDict, Union

from numpy.typing import NDArray

Numbers = Union[Sequence[float], NDArray[Any]]


class Patch(TypedDict, total=False):
    name: str
    elements: int
    share: Numbers
    elements_of: str
    sensor: Sensor
    encoder: Union[Encoder, EncoderName]
    neuron: Neuron
    field: Sequence[Field]
    outline: Union[Outline, OutlineName]
    afferents: Afferents
    spread: Spread
    kind: Literal["SA1", "RA", "PC", "SA1_DYNAMIC"]
    kinds: Sequence[Literal["SA1", "RA", "PC", "SA1_DYNAMIC"]]
    per_cm2: Numbers
    of_kind: Literal["SA1", "RA", "PC", "SA1_DYNAMIC"]
    nerve: Nerve


class Source(TypedDict, total=False):
    simulated_hand: SimulatedHand
    profile: Profile
    table: Table
    standard_input: StandardInput
    link: LinkSource
    pushed: Pushed
    hand_sensors: HandSensors
    chip: Chip
    edge: Sequence[Edge]
    indenter: Sequence[Indenter]
    grating: Sequence[Grating]
    texture: Sequence[Texture]
    grasp: Sequence[Grasp]
    dots: Sequence[Dots]
    skin: Skin


class Link(TypedDict, total=False):
    in_process: InProcess
    unix_socket: Unix
    tcp: Tcp
    udp: Udp
    serial: Serial
    file: File
    keys: str
    tick_us: float
    packet_ms: float
    prompt_ms: float
    packet_events: int
    delivery_ms: float
    stale_ms: float
    heartbeat_ms: float
    freeze_ms: float
    safe_ms: float
    encoding: Literal["RICE", "FIXED_WIDTH", "PREDICTED"]
    timing_tolerance_us: float
    connect_s: float
    channel: Channel
    bus: Bus


class Decoder(TypedDict, total=False):
    sliding_window: SlidingWindow
    exponential: Exponential
    interval: Interval
    inversion: Inversion
    filter: Filter
    window_ms: float
    curve: Literal["STEADY", "ONSET"]
    pooling: Literal["POOLED", "PER_NEURON"]
    patch: Sequence[str]
    parts: Literal["NONE", "PATCHES", "ELEMENTS"]
    contact: ContactReadout
    edge: EdgeReadout
    texture: TextureReadout


class Gain(TypedDict, total=False):
    onset_n: float
    lambda_n: float
    limit_n: float
    shape: Literal["EXPONENTIAL", "CONTINUOUS"]
    upper_bound_sigmas: float
    doubtful: Literal["BY_UPPER_BOUND", "AS_ESTIMATED"]
    saturated: float
    accept_unreachable_limit: bool
    brake: Brake
    lead_ms: float
    pulse: SlipPulse


class Hand(TypedDict, total=False):
    emg_rate_hz: float
    envelope_ms: float
    user: User
    emg_table: EmgTable
    motor: Motor
    object: Object
    safe_state: Literal["HOLD", "OPEN"]
    rearm: Literal["NEW_SESSION", "BY_USER"]
    ability_hand: Union[AbilityHand, AbilityHandName]


class Record(TypedDict, total=False):
    events: bool
    force: bool
    picture: bool


class Runtime(TypedDict, total=False):
    threads: int
    spikes_per_window: int
    skip_scans_after_ms: float


class Output(TypedDict, total=False):
    command_file: CommandFile
    live_events: LiveEvents


class Trial(TypedDict, total=False):
    user: TrialUser
    emg: SurfaceEmg
    motor: ProsthesisMotor
    object: DelicateObject
    slippery: SlipperyObject
    connection_interval_ms: float
    send_on_delta: SendOnDelta
    condition: Sequence[TrialCondition]
    sensing: TrialSensing
    untimed_events: bool


class Uncertainty(TypedDict, total=False):
    gain: float
    common_gain: float
    share: float
    share_time_s: float
    offset_n: float
    hysteresis: float
    adaptation: float


class Sensor(TypedDict, total=False):
    rate_hz: float
    full_scale_n: float
    adc_bits: int
    noise_counts: float
    force_resistance: ForceResistance
    hysteresis: float
    delay_ms: float
    calibration: Sequence[CalibrationPoint]
    dead_element: Numbers
    stuck_element: Sequence[StuckElement]
    reference_v: float
    out_of_range: Literal["CLIP", "REFUSE"]


class Encoder(TypedDict, total=False):
    sustained: Sustained
    transient: Transient
    vibration: Vibration


class Neuron(TypedDict, total=False):
    tau_m_ms: float
    tau_g_ms: float
    v_r_mv: float
    v_th_mv: float
    e_k_mv: float
    delta_g: float
    refractory_ms: float
    tuning: Tuning
    form: Literal["AUTO", "SPARSE", "DENSE"]
    fixed_point: FixedPoint
    noise_mv: float


class Field(TypedDict, total=False):
    weight: Sequence[Weight]


class Outline(TypedDict, total=False):
    rectangle: Rectangle
    ellipse: Ellipse
    pitch_mm: float
    centre: Point


class Afferents(TypedDict, total=False):
    per_cm2: float
    jitter: float
    field_sd_mm: float
    place: Sequence[Point]
    places: str


class Spread(TypedDict, total=False):
    gain: Union[Distribution, DistributionName]
    threshold: Union[Distribution, DistributionName]
    delta_g: Union[Distribution, DistributionName]
    field_sd: Union[Distribution, DistributionName]
    phase: Union[Distribution, DistributionName]
    time_class: Sequence[TimeClass]


class Nerve(TypedDict, total=False):
    length_mm: float
    speed_m_per_s: float


class SimulatedHand(TypedDict, total=False):
    pass


class Profile(TypedDict, total=False):
    point: Sequence[ProfilePoint]


class Table(TypedDict, total=False):
    path: str
    column: Sequence[str]
    out_of_range: Literal["CLIP", "REFUSE"]
    between: Literal["LINEAR", "HOLD"]
    time_column: str
    time_unit: Literal["FOUND", "SECONDS", "MILLISECONDS", "MICROSECONDS", "NANOSECONDS", "MINUTES", "DATE", "DATE_DAY_FIRST", "DATE_MONTH_FIRST"]
    rate_hz: float
    begin_s: float
    unit: Literal["BY_NAME", "NEWTONS", "COUNTS", "VOLTS"]
    missing: Literal["REFUSE_MISSING", "SKIP", "INTERPOLATE"]


class StandardInput(TypedDict, total=False):
    column: Sequence[str]
    out_of_range: Literal["CLIP", "REFUSE"]
    time_column: str
    time_unit: Literal["FOUND", "SECONDS", "MILLISECONDS", "MICROSECONDS", "NANOSECONDS", "MINUTES", "DATE", "DATE_DAY_FIRST", "DATE_MONTH_FIRST"]
    unit: Literal["BY_NAME", "NEWTONS", "COUNTS", "VOLTS"]
    missing: Literal["REFUSE_MISSING", "SKIP", "INTERPOLATE"]


class LinkSource(TypedDict, total=False):
    table: Table


class Pushed(TypedDict, total=False):
    pass


class HandSensors(TypedDict, total=False):
    pass


class Chip(TypedDict, total=False):
    device: str
    baud: int
    compare: bool


class Edge(TypedDict, total=False):
    direction_deg: float
    speed_mm_per_s: float
    begin_mm: float
    half_width_mm: float
    peak_kpa: float
    press: Press


class Indenter(TypedDict, total=False):
    x_mm: float
    y_mm: float
    direction_deg: float
    speed_mm_per_s: float
    tip: Literal["FLAT", "SPHERE"]
    radius_mm: float
    force_n: float
    depth_mm: float
    press: Press


class Grating(TypedDict, total=False):
    pad: Pad
    direction_deg: float
    speed_mm_per_s: float
    period_mm: float
    ridge_mm: float
    depth_mm: float
    press: Press


class Texture(TypedDict, total=False):
    pad: Pad
    direction_deg: float
    speed_mm_per_s: float
    rms_mm: float
    longest_mm: float
    shortest_mm: float
    hurst: float
    seed: int
    press: Press


class Grasp(TypedDict, total=False):
    point: Sequence[ProfilePoint]
    contact: Sequence[Contact]


class Dots(TypedDict, total=False):
    pad: Pad
    direction_deg: float
    speed_mm_per_s: float
    spacing_mm: float
    diameter_mm: float
    depth_mm: float
    press: Press


class Skin(TypedDict, total=False):
    modulus_kpa: float
    poisson: float
    wave: Wave


class InProcess(TypedDict, total=False):
    pass


class Unix(TypedDict, total=False):
    path: str


class Tcp(TypedDict, total=False):
    host: str
    port: int


class Udp(TypedDict, total=False):
    host: str
    port: int


class Serial(TypedDict, total=False):
    device: str
    baud: int


class File(TypedDict, total=False):
    path: str


class Channel(TypedDict, total=False):
    bandwidth_bps: float
    latency_ms: float
    jitter_ms: float
    loss: float
    reorder: float
    duplicate: float
    corrupt: float
    fifo_events: int
    drop_policy: Literal["DROP_OLDEST", "DROP_NEWEST"]


class Bus(TypedDict, total=False):
    cycle_ns: int
    rows: int
    row_events: int


class SlidingWindow(TypedDict, total=False):
    window_ms: float


class Exponential(TypedDict, total=False):
    time_constant_ms: float


class Interval(TypedDict, total=False):
    pass


class Inversion(TypedDict, total=False):
    pass


class Filter(TypedDict, total=False):
    hold: Motion
    movement: Motion
    contact: Motion


class ContactReadout(TypedDict, total=False):
    interval_ms: float


class EdgeReadout(TypedDict, total=False):
    settle_ms: float


class TextureReadout(TypedDict, total=False):
    window_ms: float


class Brake(TypedDict, total=False):
    command: float
    impulse_ms: float
    contact_n: float
    release_n: float
    release_ms: float


class SlipPulse(TypedDict, total=False):
    command: float
    pulse_ms: float
    fall_n: float
    fall_sigmas: float
    within_ms: float
    settle_ms: float
    most: int


class User(TypedDict, total=False):
    close_at_s: float
    close_for_s: float
    hold_for_s: float
    open_for_s: float
    effort: float
    ramp_s: float
    hold_effort: float


class EmgTable(TypedDict, total=False):
    path: str
    column: str
    rest_counts: float
    full_scale_counts: float
    between: Literal["LINEAR", "HOLD"]
    time_column: str
    time_unit: Literal["FOUND", "SECONDS", "MILLISECONDS", "MICROSECONDS", "NANOSECONDS", "MINUTES", "DATE", "DATE_DAY_FIRST", "DATE_MONTH_FIRST"]
    rate_hz: float
    begin_s: float
    unit: Literal["BY_NAME", "COUNTS", "VOLTS"]
    signal: Literal["AUTOMATIC", "RAW", "ENVELOPE"]
    full_scale_v: float
    missing: Literal["REFUSE_MISSING", "SKIP", "INTERPOLATE"]


class Motor(TypedDict, total=False):
    time_constant_ms: float
    speed_mm_per_s: float
    force_limit_n: float
    dead_band: float


class Object(TypedDict, total=False):
    stiffness_n_per_mm: float
    distance_mm: float


class AbilityHand(TypedDict, total=False):
    port: str
    baud: int
    address: int
    rate_hz: float
    position: PositionDrive
    velocity: VelocityDrive
    current: CurrentDrive
    duty: DutyDrive
    open_deg: float
    close_deg: float
    thumb_rotation_deg: float
    zero_counts: Numbers
    zero_drift_n: float


class CommandFile(TypedDict, total=False):
    path: str


class LiveEvents(TypedDict, total=False):
    host: str
    port: int
    path: str


class TrialUser(TypedDict, total=False):
    users: int
    begin_s: float
    reach_effort: float
    reach_spread: float
    aim_n: float
    aim_spread: float
    user_spread: float
    reaction_ms: float
    reaction_spread: float
    delay_ms: float
    contraction_ms: float
    grip_s: float
    lift_s: float
    lift_mm_per_s: float
    settle_s: float
    hold_s: float
    slip_effort: float
    patience_s: float
    press_on: float


class SurfaceEmg(TypedDict, total=False):
    centre_hz: float
    bandwidth_hz: float
    rest_effort: float


class ProsthesisMotor(TypedDict, total=False):
    aperture_mm: float
    closing_s: float
    force_limit_n: float
    time_constant_ms: float
    dead_band: float


class DelicateObject(TypedDict, total=False):
    stiffness_n_per_mm: float
    stiffness_spread: float
    breaking_force_n: float
    breaking_spread: float
    least_breaking_force_n: float
    weight_n: float
    friction: float
    distance_mm: float
    distance_spread: float


class SlipperyObject(TypedDict, total=False):
    part: float
    stiffness_n_per_mm: float
    stiffness_spread: float
    weight_n: float
    weight_spread: float
    friction: float
    taper: float
    distance_mm: float
    distance_spread: float
    aim_factor: float


class SendOnDelta(TypedDict, total=False):
    delta_n: float
    time_constant_ms: float
    threshold_events: float


class TrialCondition(TypedDict, total=False):
    name: str
    gain: Gain


class TrialSensing(TypedDict, total=False):
    gain_spread: float
    common_gain_spread: float
    share_spread: float
    dead_elements: int


class ForceResistance(TypedDict, total=False):
    maximum_ohm: float
    minimum_ohm: float
    half_force_n: float
    divider_ohm: float


class CalibrationPoint(TypedDict, total=False):
    counts: float
    force_n: float


class StuckElement(TypedDict, total=False):
    element: int
    force_n: float


class Sustained(TypedDict, total=False):
    gain_mv_per_n: float
    bias_mv: float
    dynamic: Dynamic
    slow_adaptation: SlowAdaptation


class Transient(TypedDict, total=False):
    gain_mv_s_per_n: float
    bias_mv: float
    corner_hz: float
    negative_ratio: float
    threshold_n_per_s: float


class Vibration(TypedDict, total=False):
    gain_mv_s2_per_n: float
    bias_mv: float
    corner_hz: float
    negative_ratio: float
    threshold_n_per_s2: float


class Tuning(TypedDict, total=False):
    rate: Literal["STEADY", "ONSET"]
    rate_hz: float
    force_n: float
    begin_force_n: float
    slope_n_per_s: float
    begin_slope_n_per_s: float
    other_rate_hz: float


class FixedPoint(TypedDict, total=False):
    tick_us: int
    state_bits: int
    decay_bits: int
    rounding: Literal["HALF_EVEN", "TRUNCATION"]


class Weight(TypedDict, total=False):
    element: int
    weight: float


class Rectangle(TypedDict, total=False):
    width_mm: float
    height_mm: float


class Ellipse(TypedDict, total=False):
    width_mm: float
    height_mm: float


class Point(TypedDict, total=False):
    x_mm: float
    y_mm: float


class Distribution(TypedDict, total=False):
    normal: Normal
    log_normal: LogNormal
    uniform: Uniform


class TimeClass(TypedDict, total=False):
    part: float
    tau_m: float
    tau_g: float


class ProfilePoint(TypedDict, total=False):
    time_s: float
    force_n: float


class Press(TypedDict, total=False):
    begin_s: float
    rise_s: float
    hold_s: float
    fall_s: float
    vibration_hz: float
    vibration: float


class Pad(TypedDict, total=False):
    x_mm: float
    y_mm: float
    width_mm: float
    height_mm: float
    peak_kpa: float
    stiffness_kpa_per_mm: float


class Contact(TypedDict, total=False):
    patch: str
    x_mm: float
    y_mm: float
    share: float
    radius_mm: float


class Wave(TypedDict, total=False):
    speed_m_per_s: float
    depth_mm: float
    reach_mm: float


class Motion(TypedDict, total=False):
    speed_n_per_s: float
    drift_n2_per_s: float


class PositionDrive(TypedDict, total=False):
    speed_deg_per_s: float
    lead_deg: float


class VelocityDrive(TypedDict, total=False):
    speed_deg_per_s: float


class CurrentDrive(TypedDict, total=False):
    current_a: float


class DutyDrive(TypedDict, total=False):
    duty_percent: float


class Dynamic(TypedDict, total=False):
    time_ms: float
    corner_hz: float


class SlowAdaptation(TypedDict, total=False):
    time_s: float
    part: float


class Normal(TypedDict, total=False):
    mean: float
    sd: float


class LogNormal(TypedDict, total=False):
    median: float
    sigma: float


class Uniform(TypedDict, total=False):
    lowest: float
    highest: float


# The names of the messages that stand for one of several.
SourceName = Literal["simulated_hand", "profile", "table", "standard_input", "link", "pushed", "hand_sensors", "chip"]
LinkName = Literal["in_process", "unix_socket", "tcp", "udp", "serial", "file"]
DecoderName = Literal["sliding_window", "exponential", "interval", "inversion", "filter"]
OutputName = Literal["command_file", "live_events"]
EncoderName = Literal["sustained", "transient", "vibration"]
OutlineName = Literal["rectangle", "ellipse"]
AbilityHandName = Literal["position", "velocity", "current", "duty"]
DistributionName = Literal["normal", "log_normal", "uniform"]
