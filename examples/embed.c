/* The same in C, over libafferent.so. */
#include <afferent/engine/afferent.h>
#include <inttypes.h>
#include <stdio.h>

int main(int argc, char** argv) {
    afferent_t* coprocessor = argc > 1 ? afferent_open_file(argv[1]) : NULL;
    if (!coprocessor) {
        fprintf(stderr, "%s\n", argc > 1 ? afferent_error(NULL) : "usage: embed SCENE");
        return 1;
    }
    const double forces_n[] = {0.5, 0.4, 0.3};
    afferent_event events[64];
    for (int64_t now_ns = 0; now_ns < 1000000000; now_ns += 5000000) {
        afferent_push(coprocessor, now_ns, 0, forces_n, 3);
        long count;
        do {
            count = afferent_advance(coprocessor, now_ns + 5000000, events, 64);
            for (long i = 0; i < count; ++i)
                printf("%.9f %" PRIu32 "\n", (double)events[i].time_ns / 1e9, events[i].address);
        } while (count == 64);
    }
    afferent_close(coprocessor);
    return 0;
}
