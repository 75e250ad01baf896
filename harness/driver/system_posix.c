/* Files and signals of POSIX systems. */
#define _XOPEN_SOURCE 700
#include "system_files.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

void system_prepare(void) { signal(SIGXFSZ, SIG_IGN); }

int system_create(const char *path) {
  const int file = open(path, O_WRONLY | O_CREAT, 0666);
  if (file < 0) return -1;
  /* where there are no locks, as on devices, the file is written without one */
  if (lockf(file, F_TLOCK, 0) == 0 || (errno != EACCES && errno != EAGAIN)) return file;
  close(file);
  return SYSTEM_LOCKED;
}

int system_open(const char *path) { return open(path, O_RDONLY); }

/* A signal that ends the program ends a write, too, at a page of the file (4096 bytes). */
void system_hold_signals(bool hold) {
  static sigset_t before;
  sigset_t all;
  sigfillset(&all);
  if (hold)
    sigprocmask(SIG_BLOCK, &all, &before);
  else
    sigprocmask(SIG_SETMASK, &before, NULL);
}

/* Wait for the end of standard input; the usual treatment of SIGTERM then ends the program, if it is not ignored. */
static void *wait_for_end(void *unused) {
  char bytes[256];
  for (ssize_t got = 1; got != 0;) {
    got = read(STDIN_FILENO, bytes, sizeof bytes);
    if (got < 0 && errno != EINTR) return unused;
  }
  kill(getpid(), SIGTERM);
  sleep(1);
  _exit(1);
}

int system_end_with_input(void) {
  pthread_t thread;
  /* signals are for the first thread, which may let them wait */
  system_hold_signals(true);
  const int error = pthread_create(&thread, NULL, wait_for_end, NULL);
  system_hold_signals(false);
  if (error == 0) pthread_detach(thread);
  return error;
}

bool system_same_file(const char *first, const char *second) {
  struct stat a, b;
  return stat(first, &a) == 0 && stat(second, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}
