/* asperity: case files, their runs and what a program needs around the law, C API of libasperity_run (needs LAPACK).
 *
 * A case file (docs/reference/driver.md) is read from a file or from a text, whose entries have names; rows have columns
 * with names. A handle belongs to one thread at a time, and the functions keep no data besides. A text that does not fit
 * into its buffer is cut, and a zero ends it always: with a buffer NULL of size 0 a function gives the length alone. */
#ifndef ASPERITY_RUN_H
#define ASPERITY_RUN_H

#ifdef __cplusplus
extern "C" {
#endif

/* A case file that was read, and a run of it. */
typedef struct asperity_cases asperity_cases;
typedef struct asperity_run asperity_run;

/* Size of the names of the events of a row. */
enum { ASPERITY_EVENTS = 64 };

/* Read a case file.
 *   path   file or, with a text, its name in messages; NULL: none
 *   text   content in place of that of the file; NULL: none
 *   props  double[nprops], PROPS in place of the groups &material and &pattern; NULL: none
 * The result is never NULL. asperity_case_errors says whether it can be used; asperity_free_cases frees it.
 * A handle that is NULL is an error of its own: one error, no content, no run, no row, NaN, lost. */
asperity_cases *asperity_read_cases(const char *path, const char *text, const double *props, int nprops);

/* Number of errors of a case file; message has a line for each, with file, line, group, name, value and what was
 * expected. */
int asperity_case_errors(asperity_cases *cases, char *message, int size);

/* Content of a case file as JSON: title, sweep, pattern and runs; of one with errors their list. Returns its length. */
int asperity_case_content(asperity_cases *cases, char *text, int size);

/* Free a case file; runs that have begun remain. */
void asperity_free_cases(asperity_cases *cases);

/* Take n steps (n >= 1) without entries in place of those of a case file without a sweep, then set entries of step 0 to
 * n - 1 by the names of &step: a program with many steps need not write them as text. follow is 0 for 'stable', 1 for
 * 'branch'. The steps are checked where the errors, the content or a run are asked for; then asperity_set takes no more.
 *   values  double[n]
 * Both return 0, or ASPERITY_BAD_SIZE of asperity.h for a number that is out of range, NULL, a name that no entry has,
 * or a file with a sweep. */
int asperity_steps(asperity_cases *cases, int n);
int asperity_set(asperity_cases *cases, int step, const char *name, int n, const double *values);

/* Begin the run of a value of the sweep, from 0; without a sweep it is 0. Returns NULL, with the reason in message, for
 * a case with errors, with &replay or &umat, for a number out of range, and if a tolerance is not reached. */
asperity_run *asperity_begin(asperity_cases *cases, int number, char *message, int size);

/* Take the next n increments and return how many there were: fewer than n at the end of the path, or where it has ended
 * early (asperity_lost).
 *   rows    double[n][n_columns], the first columns in the order of "columns" of asperity_tables; numbers beyond the last
 *           column are left as they are; may be NULL
 *   states  double[n][nstatv], the first state variables; numbers beyond the last one are left as they are; may be NULL
 *   events  char[n][ASPERITY_EVENTS], names of events joined by +; may be NULL */
int asperity_next(asperity_run *run, int n, int n_columns, double *rows, int nstatv, double *states, char *events);

/* Number of the last row in a column, such as "s_Tx" or "damage"; NaN before the first row and for other names. */
double asperity_value(asperity_run *run, const char *column);

/* 1 if no equilibrium was found beyond the last row, 2 if a step with fork has not left its branch and the path has ended
 * with it, both with the reason in message; else 0, with a warning in message if work and energies of the rows differ. */
int asperity_lost(asperity_run *run, char *message, int size);

/* End a run, at any row. */
void asperity_end(asperity_run *run);

/* Tables of the library as JSON: version, sizes, props, statev, columns (of rows), stability and entries (of a step).
 * Returns the length. */
int asperity_tables(char *text, int size);

/* Stability of n points from the eigenvalues of their tangents.
 *   tangent  double[n][3][3], d traction_i / d s_j
 *   numbers  double[n][6], as "stability" of asperity_tables names them
 * Returns a status of asperity.h: 0, that of props[nprops], ASPERITY_BAD_STATE for a tangent that is not finite, or
 * ASPERITY_BAD_SIZE for n < 0 or an array that is NULL. */
int asperity_stability_of(const double *props, int nprops, int n, const double *tangent, double *numbers);

#ifdef __cplusplus
}
#endif

#endif
