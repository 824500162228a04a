/* The spiking coprocessor of a scene in C: samples in, address events out. For what loads a shared library: MATLAB,
 * Python's ctypes, a firmware test rig.
 *
 * Times are nanoseconds since the start of the scene. No function throws, prints or exits; those that can fail return
 * AFFERENT_FAILED, NULL or a negative number, and afferent_error() tells why. Handles are not shared between threads
 * without a lock of the caller's.
 *
 *     afferent_t *coprocessor = afferent_open_file("grasp.txtpb");
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

enum { AFFERENT_OK = 0, AFFERENT_FAILED = -1 };

/* As in "0.1.0". */
const char *afferent_version(void);

/* A scene from a file, or from text in the same format, with its neurons tuned and at rest. NULL on failure. */
afferent_t *afferent_open_file(const char *path);
afferent_t *afferent_open_text(const char *text);

/* NULL is allowed. */
void afferent_close(afferent_t *coprocessor);

/* Why the last call with this handle failed; with NULL, why this thread's last open did. "" if it did not. Valid until
 * the next call with the handle, or the thread's next open. */
const char *afferent_error(const afferent_t *coprocessor);

/* How many neurons there are, and elements. 0 for NULL. */
uint32_t afferent_addresses(const afferent_t *coprocessor);
uint32_t afferent_elements(const afferent_t *coprocessor);

/* Samples in N, taken at that time by the elements first, first + 1, ...; each is held until its element's next. One that
 * lies before the time advanced to acts at once. Fails if one is not finite or has no element; the others are taken. */
int afferent_push(afferent_t *coprocessor, int64_t time_ns, uint32_t first, const double *forces_n, size_t count);

/* Advances to that time. Writes the events up to and including it, sorted by time and address, and returns how many. If
 * there are more than `capacity`, the first are written and the rest kept: a call with the same time, or a later one,
 * goes on with them, so the result `capacity` means "ask again". A failed call returns a negative number. */
long afferent_advance(afferent_t *coprocessor, int64_t until_ns, afferent_event *events, size_t capacity);

/* Back to the beginning of the scene. */
int afferent_reset(afferent_t *coprocessor);

#ifdef __cplusplus
}
#endif

#endif
