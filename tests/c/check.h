/* What the programs of this folder check with. */

#include <klieg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof *(array))

static inline void check(klieg_status status, const void *handle, int line) {
    if (status != KLIEG_OK) {
        fprintf(stderr, "line %d: %d: %s\n", line, (int)status, klieg_error(handle));
        exit(1);
    }
}
#define CHECK(handle, call) check(call, handle, __LINE__)

static inline void expect(int holds, const char *what, int line) {
    if (!holds) {
        fprintf(stderr, "line %d: not so: %s\n", line, what);
        exit(1);
    }
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

/* A call fails with this status, and its message has these words. */
static inline void refuse(klieg_status status, klieg_status wanted, const void *handle,
                          const char *words, int line) {
    if (status != wanted || strstr(klieg_error(handle), words) == NULL) {
        fprintf(stderr, "line %d: %d: %s; expected %d: %s\n", line, (int)status,
                klieg_error(handle), (int)wanted, words);
        exit(1);
    }
}
#define REFUSE(handle, call, wanted, words) refuse(call, wanted, handle, words, __LINE__)
