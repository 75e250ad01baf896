/* Files that the driver writes, one at a time, with what Fortran cannot do: each line is written by one system call,
 * and a line that is written in part is taken back; two runs are kept from one file; files are compared by their
 * identity, and looked into without waiting for a pipe. A file that cannot be written, or that another process has
 * changed or removed in the meantime, ends the program with code 1. */
#define _XOPEN_SOURCE 700
#include "system_files.h"

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

void output_create(const char *path);
void output_write(const char *line, size_t n);
void output_close(void);
bool output_may_replace(const char *path, const char *start);
bool output_same_file(const char *first, const char *second);

static int file = -1;     /* the open file */
static char *name = NULL; /* of it */
static uint64_t written;  /* checksum of what was written */

/* Checksum (FNV-1a) of more bytes. */
static const uint64_t no_bytes = 14695981039346656037u;
static uint64_t sum_of(uint64_t sum, const char *bytes, size_t n) {
  for (size_t i = 0; i < n; i++) sum = (sum ^ (unsigned char)bytes[i]) * 1099511628211u;
  return sum;
}

/* End the program as the last call has failed. */
static void not_written(void) {
  fprintf(stderr, "rie_driver: %s: cannot be written: %s\n", name, strerror(errno));
  exit(1);
}

/* Create or empty a file, to which no other process may write until it is closed; "-" is standard output. */
void output_create(const char *path) {
  free(name);
  name = strdup(path);
  if (name == NULL) abort();
  file = STDOUT_FILENO;
  written = no_bytes;
  system_prepare();
  if (strcmp(path, "-") == 0) return;
  file = system_create(path);
  if (file == SYSTEM_LOCKED) {
    fprintf(stderr, "rie_driver: %s: another run writes to it: expected another -o\n", name);
    exit(1);
  }
  if (file < 0) not_written();
  if (ftruncate(file, 0) != 0 && errno != EINVAL) not_written();
}

/* Whether the file of the name has what was written: a UMAT may remove it, or write to it. */
static bool is_whole(void) {
  struct stat mine, found;
  char bytes[1 << 16];
  uint64_t sum = no_bytes;
  if (fstat(file, &mine) != 0 || !S_ISREG(mine.st_mode)) return true;
  const int again = system_open(name);
  if (again < 0) return errno == EACCES;
  bool whole = fstat(again, &found) == 0 && found.st_dev == mine.st_dev && found.st_ino == mine.st_ino;
  for (ssize_t got = 1; whole && got > 0;) {
    got = read(again, bytes, sizeof bytes);
    if (got > 0) sum = sum_of(sum, bytes, (size_t)got);
  }
  close(again);
  return whole && sum == written;
}

/* Close the file. */
void output_close(void) {
  if (file == STDOUT_FILENO) return;
  const bool whole = is_whole();
  if (close(file) != 0) not_written();
  if (whole) return;
  fprintf(stderr,
          "rie_driver: %s: another program, or the UMAT, has changed or removed it: expected rows of this run\n", name);
  exit(1);
}

/* Write all bytes, or none of them to a file. */
static bool write_all(const char *line, size_t n) {
  size_t done = 0;
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
    return false;
  }
  return true;
}

/* Write a line, which no signal but SIGKILL cuts. Where a reader may be waited for, as at a pipe, signals are not kept
 * waiting. */
void output_write(const char *line, size_t n) {
  const bool waits = lseek(file, 0, SEEK_CUR) < 0;
  if (!waits) system_hold_signals(true);
  if (!write_all(line, n)) not_written();
  written = sum_of(written, line, n);
  if (!waits) system_hold_signals(false);
}

/* Whether a file is new, empty, or begins with a text of at most 64 bytes; devices, pipes and "-", standard output, are
 * not replaced. */
bool output_may_replace(const char *path, const char *start) {
  struct stat found;
  char head[64];
  const size_t n = strlen(start) < sizeof head ? strlen(start) : sizeof head;
  if (strcmp(path, "-") == 0 || stat(path, &found) != 0 || !S_ISREG(found.st_mode) || found.st_size == 0) return true;
  const int other = system_open(path);
  if (other < 0) return false;
  const ssize_t got = read(other, head, n);
  close(other);
  return got == (ssize_t)n && memcmp(head, start, n) == 0;
}

/* Whether two names denote the same existing file, also through a link. */
bool output_same_file(const char *first, const char *second) { return system_same_file(first, second); }
