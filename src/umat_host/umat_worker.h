/* What umat_call.c needs of umat_worker.c: both run in the child process. */
#ifndef UMAT_WORKER_H
#define UMAT_WORKER_H

void umat_worker_begin(int step, int increment);
void umat_worker_end_copies(void);
_Noreturn void umat_worker_fail(const char *reason);

#endif
