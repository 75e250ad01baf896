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

typedef struct {
  board_type *board;
  pid_t child;
  int rows, text;          /* pipes; -1: at their end */
  int ending, late, over;  /* the child ends itself; has begun no increment in time; has ended */
  int status;              /* of waitpid */
  double limit, since;     /* seconds; time of the last increment */
  unsigned long begun;
  unsigned long received;  /* rows */
  char *bytes;             /* received; those from `taken` on are not yet rows */
  size_t taken, filled, room;
  char line[LINE];         /* the last one that the child printed and that is not empty */
  size_t length;
  int ended_line;
} worker_type;

/* Of the child. */
static board_type *board;
static int rows_file;
static struct stat rows_known;
static unsigned long sent;
/* Of the parent: the group that ends with it. */
static volatile pid_t group;

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
  memcpy(board->notes, numbers, (size_t)n * sizeof *numbers);
  snprintf(board->text, sizeof board->text, "%s", text);
}

/* A signal that ends the parent ends the child and what it started. */
static void interrupted(int number) {
  if (group > 0) kill(-group, SIGKILL);
  signal(number, SIG_DFL);
  raise(number);
}

static void treat(const int *signals, int n, void (*from)(int), void (*to)(int)) {
  struct sigaction present;
  for (int i = 0; i < n; i++) {
    if (sigaction(signals[i], NULL, &present) == 0 && present.sa_handler == from) signal(signals[i], to);
  }
}
static const int ending[] = {SIGINT, SIGTERM, SIGHUP};

/* Begin the work in a child; NULL: there is none, the reason is in errno. */
worker_type *umat_worker_start(void (*work)(void *), void *data, double limit) {
  worker_type *const worker = calloc(1, sizeof *worker);
  int rows[2] = {-1, -1}, text[2] = {-1, -1};
  const pid_t parent = getpid();
  if (worker == NULL) return NULL;
  worker->board = mmap(NULL, sizeof *worker->board, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  worker->child = -1;
  fflush(NULL);
  if (worker->board != MAP_FAILED && pipe(rows) == 0 && pipe(text) == 0) worker->child = fork();
  if (worker->child < 0) {
    for (int i = 0; i < 2; i++) {
      if (rows[i] >= 0) close(rows[i]);
      if (text[i] >= 0) close(text[i]);
    }
    if (worker->board != MAP_FAILED) munmap(worker->board, sizeof *worker->board);
    free(worker);
    return NULL;
  }
  if (worker->child == 0) {
    setpgid(0, 0);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
#endif
    board = worker->board;
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
  setpgid(worker->child, worker->child);
  group = worker->child;
  treat(ending, 3, SIG_DFL, interrupted);
  close(rows[1]);
  close(text[1]);
  worker->rows = rows[0];
  worker->text = text[0];
  fcntl(worker->text, F_SETFL, O_NONBLOCK);
  fcntl(worker->rows, F_SETFL, O_NONBLOCK);
  worker->limit = limit;
  worker->since = now();
  worker->room = CHUNK;
  worker->bytes = malloc(worker->room);
  if (worker->bytes == NULL) abort();
  return worker;
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
static size_t pass_on(worker_type *worker) {
  char bytes[CHUNK];
  const size_t got = read_some(&worker->text, bytes, sizeof bytes);
  for (size_t i = 0, written = 0; i < got; i += written) {
    const ssize_t done = write(2, bytes + i, got - i);
    if (done < 0 && errno != EINTR) break;
    written = done > 0 ? (size_t)done : 0;
  }
  for (size_t i = 0; i < got; i++) {
    if (bytes[i] == '\n') {
      worker->ended_line = worker->length > 0;
    } else if ((unsigned char)bytes[i] >= ' ') {
      if (worker->ended_line) worker->length = 0;
      worker->ended_line = 0;
      if (worker->length < LINE - 1 && (worker->length > 0 || bytes[i] != ' ')) worker->line[worker->length++] = bytes[i];
    }
  }
  return got;
}

/* Wait a while for rows or texts; 0: the child has ended, and nothing is left. */
static int wait_some(worker_type *worker) {
  struct pollfd files[2] = {{worker->rows, POLLIN, 0}, {worker->text, POLLIN, 0}};
  siginfo_t ended = {0};
  if (worker->taken > 0) {
    worker->filled -= worker->taken;
    memmove(worker->bytes, worker->bytes + worker->taken, worker->filled);
    worker->taken = 0;
  }
  poll(files, 2, worker->over ? 0 : 50);
  const size_t got = read_some(&worker->rows, worker->bytes + worker->filled, worker->room - worker->filled);
  const size_t said = pass_on(worker);
  worker->filled += got;
  if (got + said > 0 && !worker->over) {
    if (got > 0) worker->since = now();
    return 1;
  }
  if (worker->over) return got > 0 || said > 0;
  if (waitid(P_PID, (id_t)worker->child, &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid != 0) {
    /* before the number of the group can be that of another one */
    kill(-worker->child, SIGKILL);
    group = 0;
    waitpid(worker->child, &worker->status, 0);
    worker->over = 1;
    return 1;
  }
  if (worker->begun != worker->board->begun) {
    worker->begun = worker->board->begun;
    worker->since = now();
  }
  if (!worker->ending && (worker->board->done || worker->board->reason[0])) {
    worker->ending = 1;
    worker->since = now();
  }
  if (now() - worker->since > (worker->ending ? fmin(LAST_SECONDS, worker->limit) : worker->limit)) {
    worker->late = 1;
    kill(-worker->child, SIGKILL);
  }
  return 1;
}

/* Wait for the next row of n numbers; 0: the child has ended. */
int umat_worker_receive(worker_type *worker, double *numbers, int n) {
  const size_t size = sizeof sent + (size_t)n * sizeof *numbers;
  unsigned long number;
  if (worker->room < 2 * size) {
    worker->room = 2 * size;
    worker->bytes = realloc(worker->bytes, worker->room);
    if (worker->bytes == NULL) abort();
  }
  while (worker->filled - worker->taken < size) {
    if (!wait_some(worker)) return 0;
  }
  const char *const row = worker->bytes + worker->taken;
  memcpy(&number, row, sizeof number);
  if (number != worker->received++) return 0;
  memcpy(numbers, row + sizeof number, size - sizeof number);
  worker->taken += size;
  return 1;
}

/* End the child, if it has not ended, and forget the worker: why the work is not complete (empty: it is), the last
 * increment that began (step -1: none), and the notes. Both texts have `length` bytes. */
void umat_worker_end(worker_type *worker, int n, double *notes, int *counts, char *text, char *reason, int length) {
  const board_type *const told = worker->board;
  char why[TEXT + 100], printed[LINE + 30] = "";
  if (!worker->over) {
    if (!told->done) kill(-worker->child, SIGKILL);
    while (wait_some(worker)) worker->filled = worker->taken = 0;
  }
  treat(ending, 3, interrupted, SIG_DFL);
  if (told->done) {
    why[0] = '\0';
  } else if (told->reason[0] != '\0') {
    snprintf(why, sizeof why, "%.*s", (int)sizeof told->reason, told->reason);
  } else if (worker->late) {
    snprintf(why, sizeof why, "it did not complete the increment within the limit of %g s", worker->limit);
  } else if (WIFSIGNALED(worker->status)) {
    snprintf(why, sizeof why, "it ended by signal %d (%s)", WTERMSIG(worker->status),
             strsignal(WTERMSIG(worker->status)));
  } else {
    snprintf(why, sizeof why, "it ended the program with exit code %d, as STOP or exit do",
             WEXITSTATUS(worker->status));
  }
  if (worker->length > 0) snprintf(printed, sizeof printed, "; it printed last: %.*s", (int)worker->length, worker->line);
  snprintf(reason, (size_t)length, "%s%s", why, why[0] != '\0' ? printed : "");
  snprintf(text, (size_t)length, "%.*s%s", TEXT, told->text, told->text[0] != '\0' ? printed : "");
  counts[0] = told->begun > 0 ? told->step : -1;
  counts[1] = told->increment;
  memcpy(notes, told->notes, (size_t)n * sizeof *notes);
  if (worker->rows >= 0) close(worker->rows);
  if (worker->text >= 0) close(worker->text);
  munmap(worker->board, sizeof *worker->board);
  free(worker->bytes);
  free(worker);
}

/* The whole path of a file, which may be needed elsewhere. */
void umat_whole_path(char *path, int length) {
  char *const whole = realpath(path, NULL);
  if (whole != NULL) snprintf(path, (size_t)length, "%s", whole);
  free(whole);
}
