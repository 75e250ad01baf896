/* Work in a child process, which sends rows of numbers: whatever a UMAT does ends the child only.
 *
 * The parent waits for rows, passes on what the child prints, and ends a child that begins no new increment within a
 * time limit. The child is the leader of a process group, so that processes that a UMAT starts end with it. */
#define _GNU_SOURCE
#include "umat_worker.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

enum { NOTES = 16, TEXT = 1000, LINE = 400, CHUNK = 1 << 16 };

/* Time in which a child whose work is complete or has failed must end. */
static const double LAST_SECONDS = 2.0;

/* Memory of both processes. */
typedef struct {
  volatile int done;            /* the work is complete */
  volatile unsigned long begun; /* increments and parts of them so far */
  int step, increment;          /* the last one */
  double notes[NOTES];          /* of the caller */
  char text[TEXT];              /* of the caller */
  char reason[TEXT];            /* why the child ends itself; empty: it does not */
} board_type;

/* The child that this process has started; there is one at a time. */
static struct {
  board_type *board;
  volatile pid_t id;
  int rows, text;         /* pipes; -1: at their end */
  int ending, late, over; /* the child ends itself; has begun no increment in time; has ended */
  int status;             /* of waitpid */
  int drained;            /* times that something was read since it has ended */
  double limit, since;    /* seconds; time of the last increment */
  unsigned long begun;
  unsigned long received; /* rows */
  char *bytes;            /* received; those from `taken` on are not yet rows */
  size_t taken, filled, room;
  char line[LINE]; /* the last one that the child printed and that is not empty */
  size_t length;
  int ended_line;
} child;

/* What the child itself knows. */
static board_type *board;
static int rows_file;
static struct stat rows_known;
static pid_t self;
static unsigned long sent;
static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* Note that an increment, or a part of one, begins. */
void umat_worker_begin(int step, int increment) {
  if (board == NULL) return;
  board->step = step;
  board->increment = increment;
  board->begun++;
}

/* End the child with a reason; files of the UMAT are completed. */
_Noreturn void umat_worker_fail(const char *reason) {
  if (board != NULL && board->reason[0] == '\0') snprintf(board->reason, sizeof board->reason, "%s", reason);
  exit(1);
}

/* End a process that a UMAT has started by fork, and that returned as well. */
void umat_worker_end_copies(void) {
  if (board != NULL && getpid() != self) _exit(0);
}

/* Send a row from the child. */
void umat_worker_send(const double *numbers, int n) {
  static char *row;
  const size_t size = sizeof sent + (size_t)n * sizeof *numbers;
  struct stat found;
  row = realloc(row, size);
  if (row == NULL) abort();
  memcpy(row, &sent, sizeof sent);
  memcpy(row + sizeof sent, numbers, size - sizeof sent);
  sent++;
  /* a UMAT may have closed the pipe, and opened a file of its own in its place */
  int good = fstat(rows_file, &found) == 0 && found.st_dev == rows_known.st_dev && found.st_ino == rows_known.st_ino;
  for (size_t done = 0; good && done < size;) {
    const ssize_t written = write(rows_file, row + done, size - done);
    if (written > 0) done += (size_t)written;
    good = written > 0 || errno == EINTR;
  }
  if (!good) umat_worker_fail("it closed a file of this program");
}

/* Store up to NOTES numbers and a text, which the parent finds at the end. */
void umat_worker_note(const double *numbers, int n, const char *text) {
  if (n < 0 || n > NOTES) umat_worker_fail("its increment has more notes than there is room for");
  memcpy(board->notes, numbers, (size_t)n * sizeof *numbers);
  snprintf(board->text, sizeof board->text, "%s", text);
}

/* The end of the parent ends the child and what it started. */
static void end_child(void) {
  if (child.id > 0) kill(-child.id, SIGKILL);
}

static void interrupted(int number) {
  end_child();
  signal(number, SIG_DFL);
  raise(number);
}

/* Replace one treatment of the signals that end this process by another. */
static void treat(void (*from)(int), void (*to)(int)) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction present;
  for (int i = 0; i < 3; i++) {
    if (sigaction(signals[i], NULL, &present) == 0 && present.sa_handler == from) signal(signals[i], to);
  }
}

/* Do the work in the child, which ends with it. */
static _Noreturn void be_child(void (*work)(void *), void *data, pid_t parent, const int *rows, const int *text) {
  setpgid(0, 0);
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  if (getppid() != parent) _exit(1);
  board = child.board;
  self = getpid();
  rows_file = rows[1];
  fstat(rows_file, &rows_known);
  fcntl(rows_file, F_SETFD, FD_CLOEXEC);
  close(rows[0]);
  close(text[0]);
  dup2(text[1], 1);
  dup2(text[1], 2);
  close(text[1]);
  /* a UMAT that reads finds no more */
  const int empty = open("/dev/null", O_RDONLY);
  if (empty > 0) {
    dup2(empty, 0);
    close(empty);
  }
  work(data);
  board->done = 1;
  exit(0);
}

/* Begin the work in a child. */
void umat_worker_start(void (*work)(void *), void *data, double limit) {
  int rows[2], text[2];
  pid_t id = -1;
  const pid_t parent = getpid();
  memset(&child, 0, sizeof child);
  child.limit = limit;
  child.since = now();
  child.room = CHUNK;
  child.bytes = malloc(child.room);
  child.board = mmap(NULL, sizeof *child.board, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  signal(SIGCHLD, SIG_DFL);
  fflush(NULL);
  if (child.bytes == NULL || child.board == MAP_FAILED) abort();
  if (pipe(rows) == 0 && pipe(text) == 0) id = fork();
  if (id < 0) {
    snprintf(child.board->reason, TEXT, "no process could be started: %s", strerror(errno));
    child.over = 1;
    child.rows = child.text = -1;
    return;
  }
  if (id == 0) be_child(work, data, parent, rows, text);
  setpgid(id, id);
  child.id = id;
  treat(SIG_DFL, interrupted);
  atexit(end_child);
  close(rows[1]);
  close(text[1]);
  child.rows = rows[0];
  child.text = text[0];
  fcntl(child.text, F_SETFL, O_NONBLOCK);
  fcntl(child.rows, F_SETFL, O_NONBLOCK);
}

/* Read what there is; a pipe at its end becomes -1. */
static size_t read_some(int *file, char *bytes, size_t room) {
  const ssize_t got = *file < 0 ? -1 : read(*file, bytes, room);
  if (got > 0) return (size_t)got;
  if (got < 0 && (*file < 0 || errno == EAGAIN || errno == EINTR)) return 0;
  close(*file);
  *file = -1;
  return 0;
}

/* Pass on what the child has printed, and keep its last line. */
static size_t pass_on(void) {
  char bytes[CHUNK];
  const size_t got = read_some(&child.text, bytes, sizeof bytes);
  for (size_t i = 0; i < got;) {
    const ssize_t done = write(2, bytes + i, got - i);
    if (done < 0 && errno != EINTR) break;
    if (done > 0) i += (size_t)done;
  }
  for (size_t i = 0; i < got; i++) {
    if (bytes[i] == '\n') {
      child.ended_line = child.length > 0;
    } else if ((unsigned char)bytes[i] >= ' ') {
      if (child.ended_line) child.length = 0;
      child.ended_line = 0;
      if (child.length < LINE - 1 && (child.length > 0 || bytes[i] != ' ')) child.line[child.length++] = bytes[i];
    }
  }
  return got;
}

/* Wait a while for rows or texts; 0: the child has ended, and nothing is left. */
static int wait_some(void) {
  struct pollfd files[2] = {{child.rows, POLLIN, 0}, {child.text, POLLIN, 0}};
  siginfo_t ended = {0};
  child.filled -= child.taken;
  memmove(child.bytes, child.bytes + child.taken, child.filled);
  child.taken = 0;
  poll(files, 2, child.over ? 0 : 50);
  const size_t got = read_some(&child.rows, child.bytes + child.filled, child.room - child.filled);
  const size_t said = pass_on();
  child.filled += got;
  /* a process that left the group may still print */
  if (child.over) return got > 0 || (said > 0 && child.drained++ < 3);
  const int ends = child.board->done || child.board->reason[0] != '\0';
  if (got > 0 || child.begun != child.board->begun || ends > child.ending) child.since = now();
  child.begun = child.board->begun;
  child.ending = ends;
  if (got > 0) return 1;
  if (waitid(P_PID, (id_t)child.id, &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0) {
    /* before the number of the group can be that of another one */
    kill(-child.id, SIGKILL);
    waitpid(child.id, &child.status, 0);
    child.id = 0;
    child.over = 1;
  } else if (now() - child.since > (ends ? LAST_SECONDS : child.limit)) {
    child.late = 1;
    kill(-child.id, SIGKILL);
  }
  return 1;
}

/* Wait for the next row of n numbers; 0: the child has ended. */
int umat_worker_receive(double *numbers, int n) {
  const size_t size = sizeof sent + (size_t)n * sizeof *numbers;
  unsigned long number;
  if (child.room < 2 * size) {
    child.room = 2 * size;
    child.bytes = realloc(child.bytes, child.room);
    if (child.bytes == NULL) abort();
  }
  while (child.filled - child.taken < size) {
    if (!wait_some()) return 0;
  }
  memcpy(&number, child.bytes + child.taken, sizeof number);
  if (number != child.received++) {
    snprintf(child.board->reason, sizeof child.board->reason, "it wrote to a file of this program");
    return 0;
  }
  memcpy(numbers, child.bytes + child.taken + sizeof number, size - sizeof number);
  child.taken += size;
  return 1;
}

/* End the child, if it has not ended: in which increment the work ended and why (empty: it is complete), and the notes.
 * Both texts have `length` bytes. */
void umat_worker_end(double *notes, int n, char *text, char *reason, int length) {
  const board_type *const left = child.board;
  char where[100] = "", why[TEXT + 100] = "", printed[LINE + 30] = "";
  if (!child.over && !left->done) kill(-child.id, SIGKILL);
  do child.filled = child.taken = 0;
  while (wait_some());
  treat(interrupted, SIG_DFL);
  if (left->reason[0] != '\0') {
    snprintf(why, sizeof why, "%.*s", TEXT, left->reason);
  } else if (child.late && left->done) {
    snprintf(why, sizeof why, "its process did not end within %g s after the path was complete (atexit, or a lock)",
             LAST_SECONDS);
  } else if (child.late) {
    snprintf(why, sizeof why, "it did not complete the increment within the limit of %g s", child.limit);
  } else if (WIFSIGNALED(child.status) && !left->done) {
    snprintf(why, sizeof why, "it ended by signal %d (%s)", WTERMSIG(child.status), strsignal(WTERMSIG(child.status)));
  } else if (!left->done) {
    snprintf(why, sizeof why, "it ended the program with exit code %d, as STOP or exit do", WEXITSTATUS(child.status));
  }
  if (child.length > 0) snprintf(printed, sizeof printed, "; it printed last: %.*s", (int)child.length, child.line);
  if (left->begun > 0) snprintf(where, sizeof where, "in step %d increment %d ", left->step, left->increment);
  if (left->begun > 0 && left->step == 0) snprintf(where, sizeof where, "at the start of the path ");
  snprintf(reason, (size_t)length, "%s%s%s", why[0] != '\0' ? where : "", why, why[0] != '\0' ? printed : "");
  snprintf(text, (size_t)length, "%.*s%s", TEXT, left->text, left->text[0] != '\0' ? printed : "");
  for (int i = 0; i < n; i++) notes[i] = i < NOTES ? left->notes[i] : 0.0;
  if (child.rows >= 0) close(child.rows);
  if (child.text >= 0) close(child.text);
  munmap(child.board, sizeof *child.board);
  free(child.bytes);
}
