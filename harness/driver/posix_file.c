/* What Fortran cannot do with files: compare them by their inodes, look into them without waiting for a pipe, and take
 * back a line that was written in part, and keep two runs from one file. */
#define _XOPEN_SOURCE 700
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

int posix_create(const char *path);
int posix_may_replace(const char *path, const char *start);
int posix_same_file(const char *first, const char *second);
int posix_write_line(int file, const char *line, size_t n);

/* Create or empty a file, to which no other process may write until it is closed: its descriptor, -1 with errno, or -2:
 * another process writes to it. */
int posix_create(const char *path) {
  const int file = open(path, O_WRONLY | O_CREAT, 0666);
  if (file < 0) return -1;
  /* where there are no locks, as on devices, the file is written without one */
  if (lockf(file, F_TLOCK, 0) != 0 && (errno == EACCES || errno == EAGAIN)) {
    close(file);
    return -2;
  }
  if (ftruncate(file, 0) != 0 && errno != EINVAL) return -1;
  return file;
}

/* Whether a file is new, empty, or begins with a text of at most 64 bytes; devices and pipes are not replaced. */
int posix_may_replace(const char *path, const char *start) {
  struct stat found;
  char head[64];
  const size_t n = strlen(start) < sizeof head ? strlen(start) : sizeof head;
  if (stat(path, &found) != 0 || !S_ISREG(found.st_mode) || found.st_size == 0) return 1;
  const int file = open(path, O_RDONLY);
  if (file < 0) return 0;
  const ssize_t got = read(file, head, n);
  close(file);
  return got == (ssize_t)n && memcmp(head, start, n) == 0;
}

/* Whether two names denote the same existing file, also through a link. */
int posix_same_file(const char *first, const char *second) {
  struct stat a, b;
  return stat(first, &a) == 0 && stat(second, &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/* Write all bytes of a line, or none of them to a file: 0, or -1 with errno. */
static int write_all(int file, const char *line, size_t n) {
  size_t done = 0;
  /* beyond the limit on the size of a file, write fails instead of the program */
  signal(SIGXFSZ, SIG_IGN);
  while (done < n) {
    const ssize_t written = write(file, line + done, n - done);
    if (written > 0) {
      done += (size_t)written;
      continue;
    }
    const int reason = errno;
    const off_t end = lseek(file, 0, SEEK_CUR);
    if (done > 0 && end >= (off_t)done && ftruncate(file, end - (off_t)done) == 0) {
      lseek(file, end - (off_t)done, SEEK_SET);
    }
    errno = reason;
    return -1;
  }
  return 0;
}

/* The same for a line that no signal but SIGKILL cuts: a signal that ends the program ends a write, too, at a page of
 * the file (4096 bytes). Where a reader may be waited for, as at a pipe, signals are not kept waiting. */
int posix_write_line(int file, const char *line, size_t n) {
  sigset_t all, before;
  const int waits = lseek(file, 0, SEEK_CUR) < 0;
  sigfillset(&all);
  if (!waits) sigprocmask(SIG_BLOCK, &all, &before);
  const int status = write_all(file, line, n);
  const int reason = errno;
  if (!waits) sigprocmask(SIG_SETMASK, &before, NULL);
  errno = reason;
  return status;
}
