/* What driver_output.c needs of the operating system: system_posix.c or system_windows.c has it. */
#ifndef SYSTEM_FILES_H
#define SYSTEM_FILES_H
#include <stdbool.h>

enum { SYSTEM_LOCKED = -2 };

/* Let standard output take bytes as they are, and a write beyond the limit of a file fail instead of the program. */
void system_prepare(void);
/* Open a file to write bytes to it, made if it does not exist, which no other process may write to until it is closed.
 * Returns its descriptor, SYSTEM_LOCKED if another process writes to it, or -1 with errno. */
int system_create(const char *path);
/* Open a file to read its bytes: its descriptor, or -1 with errno. */
int system_open(const char *path);
/* End this program, with the child of a UMAT, when standard input ends: it is a pipe that the caller holds open, and which
 * ends with the caller, however that ends. Returns 0, or an error. */
int system_end_with_input(void);
/* Let signals wait, or let those that came have their effect. */
void system_hold_signals(bool hold);
/* Whether two names denote the same existing file, also through a link. */
bool system_same_file(const char *first, const char *second);

#endif
