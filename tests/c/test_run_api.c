/* Case files, runs and rows in a C program (asperity_run.h); the numbers of rows are tested by the decks. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "asperity.h"
#include "asperity_run.h"
#include "check.h"

/* A fully damaged joint slides up its planes: t_Tx = |t_N| (mu + tan theta)/(1 - mu tan theta). */
#define MATERIAL "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, kc = 20.0 /\n"
#define PATTERN "&pattern sides = 2, theta = 30.0 /\n"
#define STEPS "&step t_N = -0.5, increments = 10 /\n&step slip = 0.6, increments = 24 /\n"
enum { N_ROWS = 10 + 24, N_STATEV = POINT_STATEV + 3 * PLANE_STATEV, ALL = 64 };
static const double PRESSURE = 0.5, MU = 0.5, TAN_THETA = 0.57735026918962573;
/* The tolerance of the solver is below a millionth of the strength. */
static const double TRACTION_TOLERANCE = 1e-6;

static asperity_run *begun(const char *text, const double *props, int nprops) {
  asperity_cases *cases = asperity_read_cases(NULL, text, props, nprops);
  asperity_run *run = asperity_begin(cases, 0, NULL, 0);
  asperity_free_cases(cases);
  return run;
}

static int rows_have_columns_with_names(void) {
  asperity_run *run = begun(MATERIAL PATTERN STEPS, NULL, 0);
  int bad = FAILS(run != NULL), n = 0;
  if (bad) return bad;
  bad += FAILS(isnan(asperity_value(run, "s_Tx")));
  while (asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 1) n++;
  bad += FAILS(n == N_ROWS) + FAILS(asperity_next(run, 5, 0, NULL, 0, NULL, NULL) == 0);
  double residual = PRESSURE * (MU + TAN_THETA) / (1.0 - MU * TAN_THETA);
  bad += DIFFERS(residual, asperity_value(run, "t_Tx"), TRACTION_TOLERANCE);
  bad += DIFFERS(0.6, asperity_value(run, "s_Tx"), 1e-15) + DIFFERS(2.0, asperity_value(run, "step"), 0.0);
  bad += FAILS(isnan(asperity_value(run, "t_T"))) + FAILS(isnan(asperity_value(run, NULL)));
  bad += FAILS(asperity_lost(run, NULL, 0) == 0);
  asperity_end(run);
  return bad;
}

static int rows_come_in_parts_of_any_size(void) {
  static double one[N_ROWS][ALL], parts[N_ROWS][ALL], states[N_ROWS][N_STATEV];
  static char events[N_ROWS][ASPERITY_EVENTS];
  int bad = 0, n = 0, got;
  asperity_run *run = begun(MATERIAL PATTERN STEPS, NULL, 0);
  memset(events, '#', sizeof events);
  bad += FAILS(asperity_next(run, N_ROWS, ALL, one[0], N_STATEV, states[0], events[0]) == N_ROWS);
  double damage = asperity_value(run, "damage");
  bad += DIFFERS(damage, states[N_ROWS - 1][0], 0.0) + FAILS(damage == 1.0);
  int damaged = 0;
  for (int i = 0; i < N_ROWS; i++) damaged += strstr(events[i], "damaged") != NULL;
  bad += FAILS(damaged == 1) + FAILS(memchr(events[0], '#', sizeof events) == NULL);
  asperity_end(run);
  run = begun(MATERIAL PATTERN STEPS, NULL, 0);
  while (n < N_ROWS && (got = asperity_next(run, 7, ALL, parts[n], 0, NULL, NULL)) > 0) n += got;
  bad += FAILS(n == N_ROWS) + FAILS(memcmp(one, parts, sizeof one) == 0);
  /* fewer columns than there are */
  double pair[2] = {-1.0, -1.0};
  asperity_end(run);
  run = begun(MATERIAL PATTERN STEPS, NULL, 0);
  bad += FAILS(asperity_next(run, 1, 1, pair, 1, pair + 1, NULL) == 1) + FAILS(pair[0] == 1.0 && pair[1] == 0.0);
  asperity_end(run);
  /* room for more of them: what a row does not have stays as it was */
  double wide[ALL], more[ALL];
  for (int i = 0; i < ALL; i++) wide[i] = more[i] = -7.0;
  run = begun(MATERIAL PATTERN STEPS, NULL, 0);
  bad += FAILS(asperity_next(run, 1, ALL, wide, ALL, more, NULL) == 1);
  int n_columns = 0;
  while (n_columns < ALL && wide[n_columns] != -7.0) n_columns++;
  bad += FAILS(n_columns < ALL) + FAILS(memcmp(wide, one, n_columns * sizeof(double)) == 0);
  bad += FAILS(memcmp(more, states, sizeof states[0]) == 0);
  for (int i = n_columns; i < ALL; i++) bad += FAILS(wide[i] == -7.0);
  for (int i = N_STATEV; i < ALL; i++) bad += FAILS(more[i] == -7.0);
  asperity_end(run);
  return bad;
}

static int props_stand_for_material_and_pattern(void) {
  const double props[] = {3.0, 0.3, 0.9, 0.5};
  char message[256];
  asperity_run *run = begun("&step s_N = 0x1.999999999999ap-4, increments = 1 /", props, 4);
  int bad = FAILS(run != NULL);
  if (bad) return bad;
  asperity_next(run, 1, 0, NULL, 0, NULL, NULL);
  bad += DIFFERS(0.1, asperity_value(run, "s_N"), 0.0);
  asperity_end(run);
  asperity_cases *cases = asperity_read_cases("", MATERIAL "&step s_N = 0 /", props, 4);
  bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 1) + FAILS(strstr(message, "&material") != NULL);
  asperity_free_cases(cases);
  /* IMPL-EX belongs to the UMAT */
  double implex[25] = {3.0, 0.3, 0.9, 0.5};
  implex[24] = 0.1;
  cases = asperity_read_cases("", "&step s_N = 0 /", implex, 25);
  bad +=
      FAILS(asperity_begin(cases, 0, message, sizeof message) == NULL) + FAILS(strstr(message, "implex = 0.1") != NULL);
  asperity_free_cases(cases);
  cases = asperity_read_cases("", "&step s_N = 0 /", props, 3);
  bad +=
      FAILS(asperity_case_errors(cases, message, sizeof message) == 1) + FAILS(strstr(message, "NPROPS = 3") != NULL);
  asperity_free_cases(cases);
  return bad;
}

static int steps_are_set(void) {
  const double props[] = {3.0, 0.3, 0.9, 0.5}, half = 0.05, twice[] = {0.1, 0.2}, negative = -1.0;
  char message[512];
  asperity_cases *cases = asperity_read_cases("", "&step /", props, 4);
  int bad = FAILS(asperity_set(cases, 0, "s_N", 1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_steps(cases, 0) == ASPERITY_BAD_SIZE) + FAILS(asperity_steps(cases, 2) == 0);
  const double one = 1.0;
  for (int i = 0; i < 2; i++) bad += FAILS(asperity_set(cases, i, "increments", 1, &one) == 0);
  bad += FAILS(asperity_set(cases, 0, "s_N", 1, &half) == 0) + FAILS(asperity_set(cases, 1, "s_N", 2, twice) == 0);
  bad += FAILS(asperity_set(cases, 2, "s_N", 1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_set(cases, -1, "s_N", 1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_set(cases, 0, "s_n", 1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_set(cases, 0, NULL, 1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_set(cases, 0, "s_N", -1, &half) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_set(cases, 0, "s_N", 1, NULL) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 0);
  /* a path that was checked stays as it is */
  bad += FAILS(asperity_set(cases, 0, "s_N", 1, &half) == ASPERITY_BAD_SIZE);
  asperity_run *run = asperity_begin(cases, 0, message, sizeof message);
  double rows[4][3];
  bad += FAILS(run != NULL && asperity_next(run, 4, 3, rows[0], 0, NULL, NULL) == 3);
  bad += DIFFERS(0.2, asperity_value(run, "s_N"), 0.0);
  asperity_end(run);
  /* another path, with errors; the content is made anew */
  bad += FAILS(asperity_steps(cases, 2) == 0) + FAILS(asperity_set(cases, 1, "time", 1, &negative) == 0);
  bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 1);
  bad += FAILS(strcmp(message, "&step: time = -1: expected >= 0") == 0);
  bad += FAILS(asperity_begin(cases, 0, message, sizeof message) == NULL);
  /* and a good one again: the errors are gone with their steps */
  bad += FAILS(asperity_steps(cases, 1) == 0) + FAILS(asperity_case_errors(cases, NULL, 0) == 0);
  bad += FAILS(asperity_steps(cases, 2147483647) == ASPERITY_BAD_SIZE);
  asperity_free_cases(cases);
  /* the steps of a UMAT of others are not those of this law */
  cases = asperity_read_cases("", "&umat library = 'x', nstatv = 3, length = 0.1, stiffness = 9. /\n&step s_N = 0 /",
                              NULL, 0);
  bad += FAILS(asperity_steps(cases, 1) == 0) + FAILS(asperity_set(cases, 0, "s_N", 1, &half) == 0);
  bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 0);
  asperity_free_cases(cases);
  cases = asperity_read_cases("", "&sweep name = 'far', values = 0.1 /\n&step s_N = far /", props, 4);
  bad += FAILS(asperity_case_errors(cases, NULL, 0) == 0) + FAILS(asperity_steps(cases, 1) == ASPERITY_BAD_SIZE);
  asperity_free_cases(cases);
  cases = asperity_read_cases("", "&sweep name = 'far', values = 0.1, 0.2 /\n&step s_N = far /", props, 4);
  bad += FAILS(asperity_case_errors(cases, NULL, 0) == 0) + FAILS(asperity_steps(cases, 1) == ASPERITY_BAD_SIZE);
  asperity_free_cases(cases);
  return bad + FAILS(asperity_steps(NULL, 1) == ASPERITY_BAD_SIZE) +
         FAILS(asperity_set(NULL, 0, "s_N", 1, &half) == ASPERITY_BAD_SIZE);
}

static int handles_may_be_null(void) {
  char message[200];
  double number = -1.0;
  int bad =
      FAILS(asperity_case_errors(NULL, message, sizeof message) == 1) + FAILS(strstr(message, "cases = NULL") != NULL);
  bad += FAILS(asperity_case_content(NULL, message, sizeof message) == 0);
  bad +=
      FAILS(asperity_begin(NULL, 0, message, sizeof message) == NULL) + FAILS(strstr(message, "cases = NULL") != NULL);
  bad += FAILS(asperity_next(NULL, 1, 1, &number, 0, NULL, NULL) == 0) + FAILS(number == -1.0);
  bad += FAILS(isnan(asperity_value(NULL, "s_N")));
  bad += FAILS(asperity_lost(NULL, message, sizeof message) == 1) + FAILS(strstr(message, "run = NULL") != NULL);
  asperity_end(NULL);
  asperity_free_cases(NULL);
  return bad;
}

static int errors_name_their_place(void) {
  char message[512];
  asperity_cases *cases = asperity_read_cases("slip.nml", MATERIAL PATTERN "&step slip = 0.1, tim = 1 /\n", NULL, 0);
  int bad = FAILS(asperity_case_errors(cases, message, sizeof message) == 1);
  bad += FAILS(strncmp(message, "slip.nml:3: &step: tim", 22) == 0);
  int length = asperity_case_content(cases, NULL, 0);
  bad += FAILS(length > 0) + FAILS(asperity_begin(cases, 0, message, sizeof message) == NULL);
  bad += FAILS(strstr(message, "tim") != NULL);
  char *json = malloc(length + 1);
  bad += FAILS(asperity_case_content(cases, json, length + 1) == length) + FAILS((int)strlen(json) == length);
  bad += FAILS(strstr(json, "\"name\":\"tim\"") != NULL) + FAILS(strstr(json, "\"line\":3") != NULL);
  free(json);
  asperity_free_cases(cases);
  cases = asperity_read_cases("no file", NULL, NULL, 0);
  bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 1) + FAILS(strstr(message, "no file") != NULL);
  asperity_free_cases(cases);
  asperity_free_cases(NULL);
  asperity_end(NULL);
  return bad;
}

static int a_cr_alone_ends_a_line(void) {
  const char *texts[] = {MATERIAL "! then\n" PATTERN "! the steps\n" STEPS "! end\n",
                         MATERIAL "! then\r" PATTERN "! the steps\r" STEPS "! end\r"};
  char content[2][8192];
  int bad = 0;
  for (int i = 0; i < 2; i++) {
    asperity_cases *cases = asperity_read_cases(NULL, texts[i], NULL, 0);
    bad += FAILS(asperity_case_errors(cases, NULL, 0) == 0);
    const int length = asperity_case_content(cases, content[i], sizeof content[i]);
    bad += FAILS(length > 0) + FAILS(length < (int)sizeof content[i]);
    asperity_free_cases(cases);
  }
  return bad + FAILS(strcmp(content[0], content[1]) == 0);
}

static int numbers_of_the_content_read_back(void) {
  const double values[] = {-0.0, 0.0, 3.0, -123456789.0, 0.1, 1e11, 4.9e-324, -1.0 / 3.0};
  const int n = sizeof values / sizeof *values;
  static char content[20000];
  asperity_cases *cases = asperity_read_cases(NULL, MATERIAL PATTERN "&step /\n", NULL, 0);
  int bad = FAILS(asperity_steps(cases, 1) == 0) + FAILS(asperity_set(cases, 0, "s_Ty", n, values) == 0);
  bad += FAILS(asperity_case_errors(cases, NULL, 0) == 0);
  bad += FAILS(asperity_case_content(cases, content, sizeof content) < (int)sizeof content);
  const char *at = strstr(content, "\"s_Ty\"");
  bad += FAILS(at != NULL);
  at = at ? strchr(at, '[') : NULL;
  for (int i = 0; i < n && at; i++) {
    char *end;
    const double found = strtod(at + 1, &end);
    bad += FAILS(memcmp(&found, &values[i], sizeof found) == 0);
    at = strpbrk(end, ",]");
  }
  asperity_free_cases(cases);
  return bad + FAILS(at != NULL);
}

static int what_cannot_begin_says_why(void) {
  char message[512];
  asperity_cases *cases = asperity_read_cases(NULL, MATERIAL PATTERN STEPS, NULL, 0);
  int bad = FAILS(asperity_begin(cases, 1, message, sizeof message) == NULL) +
            FAILS(strstr(message, "run 1: expected 0 to 0") != NULL) +
            FAILS(asperity_begin(cases, -1, NULL, 0) == NULL);
  asperity_free_cases(cases);
  cases = asperity_read_cases(NULL, MATERIAL PATTERN "&replay file = 'strains.csv' /", NULL, 0);
  bad += FAILS(asperity_begin(cases, 0, message, sizeof message) == NULL) + FAILS(strstr(message, "&replay") != NULL);
  asperity_free_cases(cases);
  cases = asperity_read_cases(NULL, "&umat library = 'x.so', nstatv = 1, props = 1.0 /\n" STEPS, NULL, 0);
  bad += FAILS(asperity_begin(cases, 0, message, sizeof message) == NULL) + FAILS(strstr(message, "&umat") != NULL);
  asperity_free_cases(cases);
  return bad;
}

static int loss_of_equilibrium_is_told(void) {
  char message[512];
  asperity_run *run = begun(MATERIAL PATTERN "&step t_N = 9.0, increments = 4 /\n", NULL, 0);
  int n = asperity_next(run, 100, 0, NULL, 0, NULL, NULL);
  int bad = FAILS(n > 0 && n < 4) + FAILS(asperity_lost(run, message, sizeof message) == 1);
  bad += FAILS(strstr(message, "none found") != NULL) + FAILS(asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 0);
  asperity_end(run);
  return bad;
}

static int a_fork_that_is_not_there_is_told(void) {
  char message[512];
  asperity_run *run = begun(MATERIAL PATTERN "&step t_N = -0.5, increments = 1 /\n"
                                             "&step slip = 0.05, follow = 'branch', fork = -1 /\n&step slip = 0.06 /\n",
                            NULL, 0);
  while (asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 1) {
  }
  int bad = FAILS(asperity_lost(run, message, sizeof message) == 2) + DIFFERS(2.0, asperity_value(run, "step"), 0.0);
  bad += FAILS(strcmp(message, "step 2: fork = -1: no other branch crosses in this step: expected fork = 0") == 0);
  asperity_end(run);
  return bad;
}

static int every_value_of_a_sweep_is_a_run(void) {
  asperity_cases *cases = asperity_read_cases(
      NULL, MATERIAL PATTERN "&sweep name = 'far', values = 0.1, 0.2 /\n&step s_N = far, increments = 1 /\n", NULL, 0);
  int bad = 0;
  for (int i = 0; i < 2; i++) {
    asperity_run *run = asperity_begin(cases, i, NULL, 0);
    bad += FAILS(run != NULL && asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 1);
    bad += DIFFERS(0.1 * (i + 1), asperity_value(run, "s_N"), 0.0);
    asperity_end(run);
  }
  asperity_free_cases(cases);
  return bad;
}

static int tables_name_columns(void) {
  int length = asperity_tables(NULL, 0);
  char *json = malloc(length + 1), cut[4] = "####";
  int bad = FAILS(asperity_tables(json, length + 1) == length) + FAILS((int)strlen(json) == length);
  bad += FAILS(strstr(json, "\"columns\":[\"step\",\"increment\",") != NULL);
  /* the size that this header was compiled with */
  char events[32];
  snprintf(events, sizeof events, "\"events\":%d", ASPERITY_EVENTS);
  bad += FAILS(strstr(json, events) != NULL);
  bad += FAILS(asperity_tables(cut, 3) == length) + FAILS(cut[2] == '\0' && cut[3] == '#');
  free(json);
  return bad;
}

static int stability_is_that_of_the_tangent(void) {
  /* D = K (1, 2, 3) on the diagonal: the smallest eigenvalue is that of N */
  const double props[] = {3.0, 0.3, 0.9, 0.5}, s0 = (1.0 - 0.9) * 2.0 * 0.3 / 3.0, K = 3.0 / s0;
  double tangent[2][9] = {{K, 0, 0, 0, 2 * K, 0, 0, 0, 3 * K}, {0, 0, 0, 0, K, K, 0, -K, K}}, numbers[2][6];
  int bad = FAILS(asperity_stability_of(props, 4, 2, tangent[0], numbers[0]) == ASPERITY_OK);
  bad += DIFFERS(1.0, numbers[0][0], 1e-14) + DIFFERS(1.0, numbers[0][3], 1e-14) + DIFFERS(0.0, numbers[0][2], 0.0);
  /* a rotation in the plane: eigenvalues 1 +- i */
  bad += DIFFERS(1.0, numbers[1][2], 1e-14);
  tangent[1][0] = NAN;
  bad += FAILS(asperity_stability_of(props, 4, 2, tangent[0], numbers[0]) == ASPERITY_BAD_STATE);
  bad += FAILS(asperity_stability_of(props, 3, 1, tangent[0], numbers[0]) == ASPERITY_FEW_PROPS);
  /* arrays that are NULL are told, unless they have no number */
  bad += FAILS(asperity_stability_of(NULL, 4, 1, tangent[0], numbers[0]) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_stability_of(NULL, 0, 1, tangent[0], numbers[0]) == ASPERITY_FEW_PROPS);
  bad += FAILS(asperity_stability_of(props, 4, 1, NULL, numbers[0]) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_stability_of(props, 4, 1, tangent[0], NULL) == ASPERITY_BAD_SIZE);
  bad += FAILS(asperity_stability_of(props, 4, -1, tangent[0], numbers[0]) == ASPERITY_BAD_SIZE);
  return bad + FAILS(asperity_stability_of(props, 4, 0, NULL, NULL) == ASPERITY_OK);
}

/* What the function reads of a file, it reads of a text: a byte-order mark, numbers of %A. */
static int a_text_is_read_as_a_file(void) {
  static const char content[] = "\xEF\xBB\xBF" MATERIAL PATTERN "&step s_N = -0X1.8P-4, -0x1.8p-4, increments = 1 /\n";
  const char *name = "text_as_file.nml";
  FILE *file = fopen(name, "wb");
  int bad = FAILS(file != NULL);
  if (bad) return bad;
  bad += FAILS(fputs(content, file) >= 0) + FAILS(fclose(file) == 0);
  for (int from_text = 0; from_text < 2; from_text++) {
    asperity_cases *cases = asperity_read_cases(name, from_text ? content : NULL, NULL, 0);
    char message[256];
    bad += FAILS(asperity_case_errors(cases, message, sizeof message) == 0);
    asperity_run *run = asperity_begin(cases, 0, message, sizeof message);
    bad += FAILS(run != NULL);
    for (int row = 0; run && row < 2; row++) {
      bad += FAILS(asperity_next(run, 1, 0, NULL, 0, NULL, NULL) == 1);
      bad += DIFFERS(-0.09375, asperity_value(run, "s_N"), 0.0);
    }
    asperity_end(run);
    asperity_free_cases(cases);
  }
  return bad + FAILS(remove(name) == 0);
}

int main(void) {
  int (*const tests[])(void) = {
      rows_have_columns_with_names,
      rows_come_in_parts_of_any_size,
      props_stand_for_material_and_pattern,
      errors_name_their_place,
      a_cr_alone_ends_a_line,
      numbers_of_the_content_read_back,
      what_cannot_begin_says_why,
      loss_of_equilibrium_is_told,
      a_fork_that_is_not_there_is_told,
      every_value_of_a_sweep_is_a_run,
      tables_name_columns,
      stability_is_that_of_the_tangent,
      handles_may_be_null,
      a_text_is_read_as_a_file,
      steps_are_set,
  };
  return check_run(sizeof tests / sizeof *tests, tests);
}
