// Draws the model, and lets the user pause, zoom and mark. Nothing is sent to the server.
'use strict';

const model = new Model();
const element = (id) => document.getElementById(id);

function make(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// ---- What time is shown ----

const shown = {
  span: 10,
  live: true,
  end: 0,  // where not live

  range() {
    if (model.last === null) return [0, this.span];
    const end = this.live ? Math.max(model.last, model.first + this.span) : this.end;
    return [end - this.span, end];
  },
  follow() {
    this.live = true;
    draw();
  },
  hold() {
    if (!this.live) return;
    [, this.end] = this.range();
    this.live = false;
  },
  toggle() {
    if (this.live) this.hold();
    else this.live = true;
    draw();
  },
  show(from, to) {
    this.hold();
    this.span = Math.min(Math.max(to - from, 0.05), KEPT_S);
    this.end = to;
    draw();
  },
  // About a time; the newest stays where it is while live.
  zoom(factor, about) {
    const span = Math.min(Math.max(this.span * factor, 0.05), KEPT_S);
    if (!this.live) this.end = about + ((this.end - about) * span) / this.span;
    this.span = span;
    draw();
  },
  move(share) {
    this.hold();
    this.end += share * this.span;
    draw();
  },
};

// ---- Colours ----

let colours = {};
function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['panel', 'text', 'muted', 'line', 'grid', 'true', 'estimate', 'band', 'limit', 'rate', 'gain',
    'emg', 'bytes', 'raw', 'spike', 'mark'])
    colours[name] = style.getPropertyValue(`--${name}`).trim();
}

// ---- Charts ----

const LEFT_AXIS = 84;
const FONT = '12px system-ui, "Liberation Sans", sans-serif';
const cursors = uPlot.sync('afferent');
let pointedAt = null;  // the time under the pointer

const digits = (value, places) => (value === null || value === undefined ? '–' : value.toFixed(places));
// At most four digits that matter.
const kilo = (bytes) => (bytes === null || bytes === undefined ? '–'
  : (bytes / 1000).toLocaleString('en', { maximumFractionDigits: bytes < 1e5 ? 2 : 0 }));
const line = (colour, extra = {}) => ({ stroke: colour, width: 1.75, points: { show: false }, ...extra });

// Why the force may be larger than the estimate.
const doubtText = (doubt) => ({
  slow: ' or more: slow afferents',
  unheard: ' or more: afferents not heard',
  contradicted: ' ? afferents disagree',
  unknown: ' ? nothing heard',
  saturated: ' lower bound: sensors at full scale',
}[doubt] ?? '');

// Every chart: its keys with values, what it draws, and from which columns.
const charts = {
  force: {
    title: 'Grip force',
    unit: 'N',
    keys: [['true', 'true'], ['estimate', 'estimate'], ['band', '± 2 σ'], ['limit', 'limit']],
    values: (row) => [digits(row?.true_n, 2), digits(row?.estimate_n, 2) + doubtText(row?.doubt), digits(row?.sigma_n && 2 * row.sigma_n, 2),
      digits(model.title?.limit_n, 1)],
    shows: () => model.samples.has('true_n') || model.samples.has('estimate_n'),
    series: () => [line(colours.true, { width: 2.5 }), line(colours.estimate),
      line('transparent'), line('transparent')],
    bands: () => [{ series: [3, 4], fill: colours.band }],
    data(from, to) {
      const [time, truth, estimate, sigma] = model.samples.between(from, to);
      const bound = (sign) => estimate.map((n, i) => (n === null || sigma[i] === null ? null
        : Math.max(0, n + 2 * sign * sigma[i])));
      return [time, truth, estimate, bound(1), bound(-1)];
    },
    // Where next to nothing is known, the band may be as wide as it likes.
    range(u) {
      const highest = (columns) => columns.reduce((most, column) =>
        column.reduce((each, value) => Math.max(each, value ?? 0), most), 0);
      const lines = Math.max(1, 1.08 * highest([u.data[1], u.data[2]]), 1.15 * (model.title?.limit_n ?? 0));
      return [0, Math.max(lines, Math.min(1.5 * lines, highest([u.data[3]])))];
    },
    over: (u) => model.title?.limit_n && horizontal(u, model.title.limit_n, colours.limit),
  },
  raster: {
    title: 'Events',
    unit: '',
    keys: [['spike', '']],
    values: () => [rasterText()],
    shows: () => model.raster !== null,
    series: () => [line('transparent')],
    bands: () => [],
    data: (from, to) => [[from, to], [0, 0]],
    range: () => [0, model.raster?.rows ?? 1],
    under: drawRaster,
    yAxis: () => ({ values: () => [], grid: { show: false }, ticks: { show: false } }),
  },
  rate: {
    title: 'Rate of an afferent',
    unit: 'Hz',
    keys: [['rate', 'mean']],
    values: (row) => [digits(row?.rate_hz, 1)],
    shows: () => rates().time.length > 0,
    series: () => [line(colours.rate)],
    bands: () => [],
    data: (from, to) => {
      const columns = rates();
      const all = columns.between(from, to);
      return [all[0], all[1 + columns.names.indexOf('rate_hz')]];
    },
    range: (u, low, high) => [0, Math.max(1, (high ?? 0) * 1.1)],
    columns: () => rates(),
  },
  gain: {
    title: 'Gain and EMG',
    unit: '',
    keys: [['gain', 'gain'], ['emg', 'closing EMG']],
    values: (row) => [digits(row?.gain, 2), digits(row?.emg, 2)],
    shows: () => model.samples.has('gain') || model.samples.has('emg'),
    series: () => [line(colours.gain), line(colours.emg)],
    bands: () => [],
    data(from, to) {
      const all = model.samples.between(from, to);
      return [all[0], all[5], all[6]];
    },
    range: () => [0, 1.05],
  },
  bytes: {
    title: 'Link',
    unit: 'kB/s',
    keys: [['bytes', 'events'], ['raw', 'raw samples']],
    values: (row) => [kilo(row?.bytes_per_s), kilo(model.title?.raw_bytes_per_s)],
    shows: () => model.link !== null && model.link.bytes > 0,
    series: () => [line(colours.bytes), line(colours.raw, { dash: [6, 4] })],
    bands: () => [],
    data(from, to) {
      const [time, bytes] = model.bytes.between(from, to);
      const raw = model.title?.raw_bytes_per_s;
      return [time, bytes.map((each) => each === null ? null : each / 1000), time.map(() => (raw ? raw / 1000 : null))];
    },
    // Raw samples that are far away would press the events' line to the ground: then they are told in figures alone.
    range(u) {
      const events = u.data[1].reduce((most, each) => Math.max(most, each ?? 0), 0.1);
      const raw = (model.title?.raw_bytes_per_s ?? 0) / 1000;
      return [0, 1.1 * (raw < 30 * events ? Math.max(raw, events) : events)];
    },
    columns: () => model.bytes,
  },
};

// As the decoder counts them, or else as the events are.
function rates() {
  return model.samples.has('rate_hz') ? model.samples : model.rates;
}

function rasterText() {
  if (!model.raster) return '';
  const { afferents, rows } = model.raster;
  const count = `${afferents.toLocaleString('en')} afferent${afferents === 1 ? '' : 's'}`;
  return afferents === rows ? count : `${count} in ${rows} rows: the darker, the more`;
}

// Beside their rows; names that would overlap are left out.
function drawPatchNames(u) {
  const { ctx, bbox } = u;
  const { patches, rows } = model.raster;
  const scale = devicePixelRatio;
  ctx.save();
  ctx.fillStyle = colours.muted;
  ctx.font = `${12 * scale}px system-ui, "Liberation Sans", sans-serif`;
  ctx.textAlign = 'right';
  ctx.textBaseline = 'middle';
  let free = -Infinity;
  for (const { name, first_row: first, rows: count } of patches) {
    const y = bbox.top + ((first + count / 2) / rows) * bbox.height;
    if (y < free) continue;
    free = y + 14 * scale;
    let text = name;
    for (let letters = name.length - 1; letters > 1 && ctx.measureText(text).width > bbox.left - 14 * scale; --letters)
      text = `${name.slice(0, letters)}…`;
    ctx.fillText(text, bbox.left - 6 * scale, y);
  }
  ctx.restore();
}

function horizontal(u, value, colour) {
  const { ctx, bbox } = u;
  const y = Math.round(u.valToPos(value, 'y', true)) + 0.5;
  ctx.save();
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.5 * devicePixelRatio;
  ctx.setLineDash([7 * devicePixelRatio, 5 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

// ---- The raster: one pixel of an image for each row and each pixel of time ----

const image = make('canvas');
let darkest = 1;  // the rate that is drawn in full colour, in Hz of an afferent

function rgb(colour) {
  return [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));
}

function drawRaster(u) {
  const { raster } = model;
  if (!raster || raster.end === null) return;
  const { ctx, bbox } = u;
  const [from, to] = shown.range();
  const width = Math.max(1, Math.round(bbox.width));
  const { rows } = raster;
  const rate = new Float32Array(width * rows);
  const isKnown = new Uint8Array(width);
  const perPixel = (to - from) / width / raster.bin_s;
  let highest = 0;
  for (let x = 0; x < width; ++x) {
    // A bin wider than a pixel is drawn on all of its pixels.
    const first = Math.floor(from / raster.bin_s + x * perPixel);
    const end = Math.max(first + 1, Math.floor(from / raster.bin_s + (x + 1) * perPixel));
    for (let bin = first; bin < end; ++bin) {
      if (!raster.isKnown(bin)) continue;
      isKnown[x] = 1;
      const column = (bin % raster.bins) * rows;
      for (let row = 0; row < rows; ++row) rate[row * width + x] += raster.counts[column + row];
    }
    const time = (end - first) * raster.bin_s;
    for (let row = 0; row < rows; ++row) {
      rate[row * width + x] /= time * raster.perRow[row];
      highest = Math.max(highest, rate[row * width + x]);
    }
  }
  // Follows slowly, so that the picture does not flicker.
  darkest = Math.max(10, highest > darkest ? highest : 0.97 * darkest + 0.03 * highest);

  image.width = width;
  image.height = rows;
  const context = image.getContext('2d');
  const pixels = context.createImageData(width, rows);
  const spike = rgb(colours.spike);
  const unknown = rgb(colours.grid);
  // What is still to come is left as it is.
  const end = (raster.end * raster.bin_s - from) / (to - from) * width;
  for (let row = 0; row < rows; ++row) {
    // One afferent: its spikes are seen whatever its rate.
    const least = raster.perRow[row] <= 1 ? 0.45 : 0.15;
    for (let x = 0; x < width; ++x) {
      if (x >= end) continue;
      const each = rate[row * width + x];
      const at = 4 * (row * width + x);
      pixels.data.set(isKnown[x] ? spike : unknown, at);
      const dark = each > 0 ? Math.max(least, Math.sqrt(Math.min(1, each / darkest))) : 0;
      pixels.data[at + 3] = isKnown[x] ? 255 * dark : 255;
    }
  }
  context.putImageData(pixels, 0, 0);
  ctx.save();
  ctx.imageSmoothingEnabled = false;
  ctx.drawImage(image, bbox.left, bbox.top, bbox.width, bbox.height);
  // Lost packets.
  ctx.fillStyle = colours.grid;
  for (const gap of model.gaps) {
    const left = Math.max(bbox.left, u.valToPos(gap.from_s, 'x', true));
    const right = Math.min(bbox.left + bbox.width, u.valToPos(gap.to_s, 'x', true));
    if (left < right) ctx.fillRect(left, bbox.top, Math.max(right - left, devicePixelRatio), bbox.height);
  }
  // Thin lines between the rows where they can be told apart, and between patches.
  const height = bbox.height / rows;
  const border = (row, colour, thick) => {
    ctx.fillStyle = colour;
    ctx.fillRect(bbox.left, Math.round(bbox.top + row * height - thick / 2), bbox.width, thick);
  };
  if (height > 6 * devicePixelRatio)
    for (let row = 1; row < rows; ++row) border(row, colours.panel, 2 * devicePixelRatio);
  const isRoomy = bbox.height / raster.patches.length > 14 * devicePixelRatio;
  for (const patch of raster.patches)
    if (isRoomy && patch.first_row > 0) border(patch.first_row, colours.line, devicePixelRatio);
  ctx.restore();
  drawPatchNames(u);
}

// ---- Marks ----

const marks = [];

function drawMarks(u, isNumbered) {
  const { ctx, bbox } = u;
  const [from, to] = shown.range();
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colours.mark;
  ctx.lineWidth = 1.25 * devicePixelRatio;
  ctx.setLineDash([]);
  ctx.font = `bold ${12 * devicePixelRatio}px sans-serif`;
  ctx.textAlign = 'left';
  ctx.textBaseline = 'top';
  for (const mark of marks) {
    if (mark.course !== model.course || mark.time_s < from || mark.time_s > to) continue;
    const x = Math.round(u.valToPos(mark.time_s, 'x', true)) + 0.5;
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    if (isNumbered) ctx.fillText(mark.number, x + 5 * devicePixelRatio, bbox.top);
  }
  ctx.restore();
}

function addMark() {
  if (model.last === null) return;
  const time = pointedAt ?? model.last;
  const sample = model.samples.at(time);
  const mark = { number: (marks.at(-1)?.number ?? 0) + 1, course: model.course, time_s: time, label: '', sample };
  marks.push(mark);
  const label = make('input', { placeholder: `${digits(sample?.estimate_n, 2)} N`, maxLength: 80 });
  label.setAttribute('aria-label', `Label of mark ${mark.number}`);
  label.addEventListener('input', () => { mark.label = label.value; });
  const remove = make('button', { type: 'button', textContent: '×', title: 'Remove' });
  remove.setAttribute('aria-label', `Remove mark ${mark.number}`);
  const item = make('li', {}, make('span', { className: 'number', textContent: mark.number }),
    make('span', { textContent: `${time.toFixed(3)} s` }), label, remove);
  remove.addEventListener('click', () => {
    marks.splice(marks.indexOf(mark), 1);
    item.remove();
    draw();
  });
  element('marks').append(item);
  draw();
}

function marksAsCsv() {
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  const names = model.samples.names;
  const rows = marks.map((mark) => [mark.number, mark.course, mark.time_s, quoted(mark.label),
    ...names.map((name) => mark.sample?.[name] ?? '')]);
  return [['mark', 'course', 'time_s', 'label', ...names], ...rows].map((row) => `${row.join(',')}\n`).join('');
}

function saveMarks() {
  const url = URL.createObjectURL(new Blob([marksAsCsv()], { type: 'text/csv' }));
  make('a', { href: url, download: `${model.title?.scene || 'scene'}-marks.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

// ---- Putting the charts up ----

function axes(chart, isLast) {
  const common = { stroke: colours.muted, font: FONT, grid: { stroke: colours.grid, width: 1 },
    ticks: { stroke: colours.line, width: 1, size: 4 } };
  return [
    { ...common, size: isLast ? 36 : 8, values: (u, splits) => splits.map((each) => (isLast ? `${+each.toFixed(4)} s` : '')) },
    { ...common, size: LEFT_AXIS, ...(chart.yAxis ? chart.yAxis() : { space: 28 }) },
  ];
}

function putUp(name) {
  const chart = charts[name];
  const values = [];
  const keys = chart.keys.map(([colour, text]) => {
    const value = make('b');
    values.push(value);
    return make('span', { className: 'key' }, make('i', { className: `colour-${colour}` }), `${text} `, value);
  });
  const title = chart.unit ? `${chart.title}, ${chart.unit}` : chart.title;
  chart.place = make('div', { className: 'plot' });
  chart.shownValues = values;
  chart.section = make('section', { className: `chart ${name}` },
    make('div', { className: 'head' }, make('h2', { textContent: title }), ...keys), chart.place);
  chart.section.setAttribute('aria-label', title);
  element('charts').append(chart.section);
}

function plot(name, isLast) {
  const chart = charts[name];
  chart.plot?.destroy();
  chart.isLast = isLast;
  const { clientWidth: width, clientHeight: height } = chart.place;
  const plotted = new uPlot({
    width: Math.max(width, 50),
    height: Math.max(height, 50),
    legend: { show: false },
    padding: [6, 14, 0, 0],
    scales: {
      x: { time: false, range: () => shown.range() },
      y: { range: (u, low, high) => chart.range(u, low, high) },
    },
    axes: axes(chart, isLast),
    series: [{}, ...chart.series()],
    bands: chart.bands(),
    cursor: { sync: { key: cursors.key, scales: ['x', null] }, y: false, points: { show: false },
      drag: { x: true, y: false, setScale: false } },
    hooks: {
      drawAxes: [(u) => chart.under?.(u)],
      draw: [(u) => { chart.over?.(u); drawMarks(u, name === 'force'); }],
      setCursor: [(u) => {
        const time = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, 'x') : null;
        if (time === pointedAt) return;
        pointedAt = time;
        showValues();
      }],
      setSelect: [(u) => {
        if (u.select.width < 4) return;
        const from = u.posToVal(u.select.left, 'x');
        const to = u.posToVal(u.select.left + u.select.width, 'x');
        u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
        shown.show(from, to);
      }],
    },
  }, chart.data(...shown.range()), chart.place);
  plotted.over.addEventListener('dblclick', () => shown.follow());
  plotted.over.addEventListener('wheel', (event) => {
    event.preventDefault();
    shown.zoom(event.deltaY > 0 ? 1.25 : 0.8, pointedAt ?? shown.end);
  }, { passive: false });
  chart.plot = plotted;
}

const names = Object.keys(charts);

// Charts without data are not there; the last one has the axis of time.
function arrange(anew = false) {
  const visible = names.filter((name) => charts[name].shows());
  let moved = false;
  for (const name of names) {
    const { section } = charts[name];
    moved ||= section.hidden === visible.includes(name);
    section.hidden = !visible.includes(name);
  }
  if (moved) fit();
  for (const name of visible) {
    const isLast = name === visible.at(-1);
    if (anew || !charts[name].plot || charts[name].isLast !== isLast) plot(name, isLast);
  }
  return visible;
}

function fit() {
  for (const name of names) {
    const { plot: plotted, place, section } = charts[name];
    if (plotted && !section.hidden) plotted.setSize({ width: place.clientWidth, height: place.clientHeight });
  }
}

// ---- Text ----

const percent = (value) => (value === null ? null : `${value.toFixed(2)} ms`);
const counted = (value) => (value === null ? null : value.toLocaleString('en'));

// What the table says of the link: a name, its value, and how good that is. Null: not known, and not shown.
function linkRows() {
  const { link, title } = model;
  if (!link) return [];
  const bad = (count) => (count > 0 ? 'warn' : '');
  const last = model.bytes.bytes_per_s.at(-1) ?? null;
  const grade = { operating: 'good', frozen: 'warn', safe: 'bad' }[link.grip];
  return [
    ['Session', link.session || null, { open: 'good', none: 'warn' }[link.session]],
    ['Grip', link.grip || null, grade],
    ...(link.grip !== 'operating' && link.reason ? [[link.reason]] : []),
    ['Sessions', link.sessions > 1 ? counted(link.sessions) : null],
    ['Packets', counted(link.packets)],
    ['Events', counted(link.events)],
    ['Bytes', link.bytes > 0 ? counted(link.bytes) : null],
    [`Of raw samples, last ${BYTES_OVER_S} s`, last !== null && title.raw_bytes_per_s > 0
      ? `${+((100 * last) / title.raw_bytes_per_s).toPrecision(2)} %` : null],
    ['Gaps', counted(link.gaps), bad(link.gaps)],
    ['Lost events', counted(link.lost_events), bad(link.lost_events)],
    ['Late packets', counted(link.late_packets), bad(link.late_packets)],
    ['Stale packets', counted(link.stale_packets), bad(link.stale_packets)],
    ['Dropped packets', link.dropped_packets ? counted(link.dropped_packets) : null, 'warn'],
    ['Refused frames', link.refused_frames ? counted(link.refused_frames) : null, 'warn'],
    ['Steps late, median', percent(link.lateness_p50_ms)],
    ['Steps late, 99 %', percent(link.lateness_p99_ms)],
    ['Steps late, most', percent(link.lateness_max_ms)],
    ['Missed deadlines', counted(link.missed_deadlines), bad(link.missed_deadlines)],
    ...(link.motors ?? []).map(({ name, position_deg: deg, current_a: amperes }) =>
      [`Motor: ${name}`, `${deg.toFixed(0)}° ${amperes.toFixed(2)} A`]),
    ['Temperature', link.temperature || null, link.temperature === 'normal' ? 'good' : 'bad'],
    ['Not shown here', model.dropped ? `${counted(model.dropped)} messages` : null, 'warn'],
    ['Not shown at all', model.unseen ? `${counted(model.unseen)} parts` : null, 'warn'],
  ].filter(([, value]) => value !== null);
}

function showLink() {
  element('link').tBodies[0].replaceChildren(...linkRows().map(([name, value, grade]) =>
    make('tr', {}, ...(value === undefined ? [make('td', { colSpan: 2, textContent: name })]
      : [make('td', { textContent: name }), make('td', { textContent: value, className: grade ?? '' })]))));
}

function showNotes() {
  element('notes').replaceChildren(...model.notes.slice(-8).reverse().map((note) =>
    make('li', { textContent: `${note.time_s.toFixed(2)} s  ${note.text}` })));
  element('notes').parentElement.hidden = model.notes.length === 0;
}

// At the pointer, or the newest.
function showValues() {
  const time = pointedAt ?? (shown.live ? model.last : shown.end);
  for (const name of names) {
    const chart = charts[name];
    const columns = chart.columns ? chart.columns() : model.samples;
    const row = time === null ? null : columns.at(time);
    chart.values(row).forEach((text, i) => { chart.shownValues[i].textContent = text; });
  }
  element('time').textContent = time === null ? '' : `${time.toFixed(2)} s`;
}

let connection = 'connecting';
function showState() {
  const state = connection !== 'open' ? connection : model.ended ? 'ended' : shown.live ? 'live' : 'paused';
  const badge = element('state');
  if (badge.dataset.state !== state) {
    badge.dataset.state = state;
    badge.textContent = state;
  }
  element('pause').textContent = shown.live ? 'Pause' : 'Follow';
  const choice = [...element('window').options].find((each) => +each.value === shown.span);
  element('window').value = choice ? choice.value : '';
  element('no-marks').hidden = marks.length > 0;
  element('export').hidden = marks.length === 0;
  if (!model.title) return;
  element('scene').textContent = model.title.scene || 'Scene';
  document.title = `${model.title.scene || 'Scene'} · afferent ${model.title.command}`;
}

let isDue = false;
function draw() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    showState();
    showLink();
    showNotes();
    for (const name of arrange()) charts[name].plot.setData(charts[name].data(...shown.range()));
    showValues();
  });
}

// ---- The connection ----

// The server may be started again at the same address.
const RETRY_MS = 1000;

function connect() {
  const socket = new WebSocket(new URL('socket', location.href.replace(/^http/, 'ws')));
  socket.addEventListener('open', () => { connection = 'open'; });
  socket.addEventListener('message', (event) => {
    const before = model.course;
    model.take(JSON.parse(event.data));
    if (model.course !== before) shown.live = true;
    draw();
  });
  socket.addEventListener('close', () => {
    connection = model.ended ? 'ended' : 'reconnecting';
    draw();
    setTimeout(connect, RETRY_MS);
  });
}

// ---- Begin ----

element('pause').addEventListener('click', () => shown.toggle());
element('mark').addEventListener('click', addMark);
element('export').addEventListener('click', saveMarks);
element('window').addEventListener('change', (event) => {
  shown.span = +event.target.value;
  draw();
});
document.addEventListener('keydown', (event) => {
  if (event.target.matches('input, select') || event.ctrlKey || event.metaKey || event.altKey) return;
  const about = pointedAt ?? shown.range()[1];
  const action = {
    ' ': () => shown.toggle(),
    m: addMark,
    '+': () => shown.zoom(0.8, about),
    '-': () => shown.zoom(1.25, about),
    ArrowLeft: () => shown.move(-0.1),
    ArrowRight: () => shown.move(0.1),
    Home: () => shown.follow(),
  }[event.key];
  if (!action) return;
  event.preventDefault();
  action();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  readColours();
  arrange(true);
  draw();
});
readColours();
names.forEach(putUp);
new ResizeObserver(fit).observe(element('charts'));
draw();
connect();

// For the browser's console, and for tests.
globalThis.afferentView = { model, shown, marks, marksAsCsv };
