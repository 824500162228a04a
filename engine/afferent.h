/* A scene in C: its spiking coprocessor (samples in, address events out) and the controller of its hand
 * (events or packets and EMG in, estimate and command out). Included by C programs, and
 * by whatever loads a shared library: MATLAB, Python's ctypes, a firmware test rig.
 *
 * Times are nanoseconds since the start of the scene. No function throws, prints or exits; those that can
 * fail return AFFERENT_FAILED, NULL or a negative number, and afferent_error() or afferent_controller_error()
 * tells why. A handle may be used by one thread at a time.
 *
 *     afferent_t* coprocessor = afferent_open_file("grasp.txtpb");
 *     if (!coprocessor) { fputs(afferent_error(NULL), stderr); return 1; }
 *     afferent_push(coprocessor, time_ns, 0, forces_n, 9);
 *     afferent_event events[256];
 *     long count = afferent_advance(coprocessor, time_ns + 5000000, events, 256);
 *     afferent_close(coprocessor);
 */
#ifndef AFFERENT_SCENE_AFFERENT_H
#define AFFERENT_SCENE_AFFERENT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct afferent_coprocessor afferent_t;

typedef struct {
    int64_t time_ns;
    uint32_t address;
} afferent_event;

/* AFFERENT_FULL: nothing was done, because the samples that wait have reached their limit; advance, and try
 * again. */
enum { AFFERENT_OK = 0, AFFERENT_FAILED = -1, AFFERENT_FULL = -2 };

/* As in "0.1.0". */
const char* afferent_version(void);

/* A scene from a file, or from text in the same format, its neurons tuned and at rest. NULL on failure. */
afferent_t* afferent_open_file(const char* path);
afferent_t* afferent_open_text(const char* text);

/* NULL is allowed. */
void afferent_close(afferent_t* coprocessor);

/* Why the last call with this handle failed; with NULL, why this thread's last open did. "" if it did not.
 * Valid until the next call with the handle, or the thread's next open. */
const char* afferent_error(const afferent_t* coprocessor);

/* How many neurons there are, and elements. 0 for NULL. */
uint32_t afferent_addresses(const afferent_t* coprocessor);
uint32_t afferent_elements(const afferent_t* coprocessor);

/* Samples in N, taken at that time by the elements first, first + 1, ...; each is held until its element's
 * next. One that lies before the time advanced to acts at once. As in a table, a force below 0 or beyond the
 * sensor's full scale is clipped, and counted; where the sensor says out_of_range: REFUSE, it is refused.
 * Fails if a sample is refused, is not finite or has no element; the others are taken. AFFERENT_FULL if more
 * than 2^20 samples, or eight of each element, would wait. */
int afferent_push(afferent_t* coprocessor, int64_t time_ns, uint32_t first, const double* forces_n,
                  size_t count);

/* How many samples have been clipped. 0 for NULL. */
uint64_t afferent_clipped(const afferent_t* coprocessor);

/* Advances to that time. Writes the events up to and including it, sorted by time and address, and returns
 * how many. If there are more than `capacity`, the first are written, and a call with the same time, or a
 * later one, goes on with the others: the result `capacity` means "ask again". No more is computed than is
 * asked for, so that no time, however far, takes more memory than the events of some milliseconds. A failed
 * call returns a negative number. */
long afferent_advance(afferent_t* coprocessor, int64_t until_ns, afferent_event* events, size_t capacity);

/* Back to the beginning of the scene. */
int afferent_reset(afferent_t* coprocessor);

/* ---- the controller ---- */

typedef struct afferent_controller afferent_controller_t;
typedef struct afferent_snapshot afferent_snapshot_t;

/* What the closing command may be: as the user and the gain say; no increase; the scene's safe state. Who has
 * a clock and a link sets it, because silence on the link is not the controller's business. */
enum { AFFERENT_OPERATING = 0, AFFERENT_FROZEN = 1, AFFERENT_SAFE = 2 };

/* Why the grip force may be larger than an estimate and its sigma say. With AFFERENT_DOUBT_SATURATED the
 * sensors are at full scale, and the estimate is a lower bound. */
enum {
    AFFERENT_DOUBT_NONE = 0,
    AFFERENT_DOUBT_SLOW = 1,    /* silent, but no longer than afferents that fire seldom may be */
    AFFERENT_DOUBT_UNHEARD = 2, /* afferents that would fire have not been heard since the contact began */
    AFFERENT_DOUBT_CONTRADICTED = 3, /* most of the afferents contradict each other */
    AFFERENT_DOUBT_UNKNOWN = 4,      /* nothing has been known for so long that the estimate is an old one */
    AFFERENT_DOUBT_SATURATED = 5
};

/* What the controller knew and did at one step. */
typedef struct {
    int64_t time_ns;
    double force_n; /* estimate of the grip force */
    double sigma_n; /* one standard deviation of it */
    double rate_hz; /* mean over the afferents that are read */
    double gain;    /* of the closing EMG, 0 to 1 */
    double command; /* to the motor, -1 (open) to 1 (close) */
    int doubt;      /* one of the above; its own zero is AFFERENT_DOUBT_NONE */
} afferent_step;

/* A doubt in a word, such as "saturated"; "none" for anything else. */
const char* afferent_doubt_name(int doubt);

/* The controller of a scene from a file, or from text in the same format. NULL on failure:
 * afferent_controller_error(NULL) tells why. */
afferent_controller_t* afferent_controller_open_file(const char* path);
afferent_controller_t* afferent_controller_open_text(const char* text);

/* NULL is allowed. */
void afferent_controller_close(afferent_controller_t* controller);

/* As afferent_error(). */
const char* afferent_controller_error(const afferent_controller_t* controller);

/* A packet as the link has brought it: one frame, without the length that streams put before it. Fails if it
 * was not used. */
int afferent_controller_receive(afferent_controller_t* controller, const void* frame, size_t bytes);

/* All events of [begin, end), sorted by time and address: silence is a measurement. Spans come in the order
 * of time. */
int afferent_controller_observe(afferent_controller_t* controller, int64_t begin_ns, int64_t end_ns,
                                const afferent_event* events, size_t count);
/* Nothing will ever be known of [begin, end). */
int afferent_controller_lose(afferent_controller_t* controller, int64_t begin_ns, int64_t end_ns);

/* Once for each period of the scene's EMG: what the closing and the opening electrode read, in counts. */
int afferent_controller_step(afferent_controller_t* controller, int64_t now_ns, double closing_counts,
                             double opening_counts, afferent_step* step);

/* How many patches or elements have an estimate of their own, as the scene's decoder { parts } says, in the
 * order of the scene; 0 for NULL. The estimate of one of them at the last step: force and one standard
 * deviation, in N on that part. */
size_t afferent_controller_parts(const afferent_controller_t* controller);
int afferent_controller_part(afferent_controller_t* controller, size_t part, double* force_n,
                             double* sigma_n);
/* The doubt of that estimate. */
int afferent_controller_part_doubt(afferent_controller_t* controller, size_t part, int* doubt);

/* AFFERENT_OPERATING, AFFERENT_FROZEN or AFFERENT_SAFE. */
int afferent_controller_set_state(afferent_controller_t* controller, int state);

/* A new session: nothing is known of before, and the grip is operating. */
int afferent_controller_restart(afferent_controller_t* controller, int64_t now_ns);

/* Everything that the next step depends on; to be freed. NULL on failure. */
afferent_snapshot_t* afferent_controller_snapshot(afferent_controller_t* controller);
/* Continues from there, bit for bit; the snapshot may be used again. Fails where it is of another scene. */
int afferent_controller_resume(afferent_controller_t* controller, const afferent_snapshot_t* snapshot);
/* NULL is allowed. */
void afferent_snapshot_free(afferent_snapshot_t* snapshot);

#ifdef __cplusplus
}
#endif

#endif
