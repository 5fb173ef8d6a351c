/* ARKODE's ERKStep with the method of Dormand and Prince on accelerations written by hand; position and velocity are
 * projected after each step (ERKStepSetPostprocessStepFn). Arguments and output are those of program/taut_benchmark.f90. */
#include <arkode/arkode_erkstep.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_version.h>
#include <time.h>

#define G 9.81
#define MAX_ITERATIONS 25

void dgbsv_(int *n, int *kl, int *ku, int *nrhs, double *ab, int *ldab, int *ipiv, double *b, int *ldb, int *info);

typedef struct {
   int n;                                /* rods of the chain, or loops */
   double *unit, *cosine, *right, *work; /* rods' directions, their products, right side, and what the solution needs */
   double *band;
   int *pivot;
} Model;

typedef int (*Rates)(double t, N_Vector y, N_Vector rate, void *data);
typedef int (*Project)(double t, N_Vector y, void *data);

/* Pendulum: y = {x, z, vx, vz}. */

static int pendulum_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   const double *y = N_VGetArrayPointer(vector);
   double *rate = N_VGetArrayPointer(rate_vector);
   double r2 = y[0] * y[0] + y[1] * y[1];
   double across = y[0] * y[3] - y[1] * y[2];
   double tension = (across * across / r2 - y[1] * G) / r2;
   rate[0] = y[2];
   rate[1] = y[3];
   rate[2] = -y[0] * tension;
   rate[3] = -G - y[1] * tension;
   return 0;
}

static int pendulum_project(double t, N_Vector vector, void *data) {
   double *y = N_VGetArrayPointer(vector);
   double scale = 1.0 / sqrt(y[0] * y[0] + y[1] * y[1]);
   y[0] *= scale;
   y[1] *= scale;
   double mu = y[0] * y[2] + y[1] * y[3];
   y[2] -= y[0] * mu;
   y[3] -= y[1] * mu;
   return 0;
}

/* Chain: y = {x1, z1, x2, ...; their rates}; S is tridiagonal with 1, 2, 2, ... and minus the cosines between rods. */

static double chain_rods(Model *m, const double *y) {
   double ox = 0.0, oz = 0.0, worst = 0.0;
   for (int i = 0; i < m->n; i++) {
      double dx = y[2 * i] - ox, dz = y[2 * i + 1] - oz, length = sqrt(dx * dx + dz * dz), r = 1.0 / length;
      ox = y[2 * i];
      oz = y[2 * i + 1];
      m->unit[2 * i] = dx * r;
      m->unit[2 * i + 1] = dz * r;
      m->right[i] = length - 1.0;
      worst = fmax(worst, fabs(length - 1.0));
      if (i > 0) m->cosine[i] = m->unit[2 * i] * m->unit[2 * i - 2] + m->unit[2 * i + 1] * m->unit[2 * i - 1];
   }
   return worst;
}

/* right = S^-1 right. */
static void chain_solve(Model *m) {
   double *c = m->work, *x = m->right, pivot = 1.0;
   for (int i = 1; i < m->n; i++) {
      c[i - 1] = -m->cosine[i] * pivot;
      pivot = 1.0 / (2.0 + m->cosine[i] * c[i - 1]);
      x[i] = (x[i] - x[i - 1] * -m->cosine[i]) * pivot;
   }
   for (int i = m->n - 2; i >= 0; i--) x[i] -= c[i] * x[i + 1];
}

/* y -= A^T right. */
static void chain_subtract(Model *m, double *y) {
   for (int i = 0; i < m->n; i++) {
      for (int k = 0; k < 2; k++) {
         double value = m->unit[2 * i + k] * m->right[i];
         y[2 * i + k] -= value;
         if (i > 0) y[2 * i - 2 + k] += value;
      }
   }
}

static int chain_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   Model *m = data;
   int n = m->n;
   const double *y = N_VGetArrayPointer(vector), *v = y + 2 * n;
   double *rate = N_VGetArrayPointer(rate_vector), ox = 0.0, oz = 0.0;
   chain_rods(m, y);
   for (int i = 0; i < n; i++) {
      double across = m->unit[2 * i] * (v[2 * i + 1] - oz) - m->unit[2 * i + 1] * (v[2 * i] - ox);
      ox = v[2 * i];
      oz = v[2 * i + 1];
      m->right[i] = across * across / (1.0 + m->right[i]);
      rate[2 * i] = v[2 * i];
      rate[2 * i + 1] = v[2 * i + 1];
      rate[2 * n + 2 * i] = 0.0;
      rate[2 * n + 2 * i + 1] = -G;
   }
   m->right[0] -= G * m->unit[1];
   chain_solve(m);
   chain_subtract(m, rate + 2 * n);
   return 0;
}

static int chain_project(double t, N_Vector vector, void *data) {
   Model *m = data;
   double *y = N_VGetArrayPointer(vector), *v = y + 2 * m->n, limit = fmax(1e-12, 4.0 * 2.2e-16 * m->n);
   for (int k = 0; chain_rods(m, y) > limit; k++) {
      if (k == MAX_ITERATIONS) return -1;
      chain_solve(m);
      chain_subtract(m, y);
   }
   for (int i = 0; i < m->n; i++) {
      m->right[i] = m->unit[2 * i] * v[2 * i] + m->unit[2 * i + 1] * v[2 * i + 1];
      if (i > 0) m->right[i] -= m->unit[2 * i] * v[2 * i - 2] + m->unit[2 * i + 1] * v[2 * i - 1];
   }
   chain_solve(m);
   chain_subtract(m, v);
   return 0;
}

/* N four-bar loops: y = {x, y of B_0, B_1, ...; their rates}. Unknowns in the order ax, ay, crank's and next rod's force
 * of each B make [M A^T; A 0] a band of 5, which LAPACK solves with pivoting. Directions of cranks and rods alternate. */

#define BAND 5
#define ROWS (3 * BAND + 1)

static double *entry(Model *m, int i, int j) { return m->band + (long)j * ROWS + 2 * BAND + i - j; }

static double loops_rods(Model *m, const double *y) {
   double worst = 0.0;
   for (int i = 0; i <= m->n; i++) {
      for (int rod = 0; rod < 2 && !(rod && i == m->n); rod++) {
         double dx = rod ? y[2 * i + 2] - y[2 * i] : y[2 * i] - i;
         double dy = rod ? y[2 * i + 3] - y[2 * i + 1] : y[2 * i + 1];
         double length = sqrt(dx * dx + dy * dy);
         m->unit[4 * i + 2 * rod] = dx / length;
         m->unit[4 * i + 2 * rod + 1] = dy / length;
         m->cosine[2 * i + rod] = length - 1.0;
         worst = fmax(worst, fabs(length - 1.0));
      }
   }
   return worst;
}

/* work = [M A^T; A 0]^-1 work, M the mass or one. */
static int loops_solve(Model *m, int mass) {
   int last = m->n, size = 4 * (m->n + 1) - 1, k = BAND, rows = ROWS, one = 1, info;
   memset(m->band, 0, sizeof(double) * ROWS * size);
   for (int i = 0; i <= last; i++) {
      const double *crank = m->unit + 4 * i, *rod = crank + 2;
      for (int d = 0; d < 2; d++) {
         int at = 4 * i + d;
         *entry(m, at, at) = mass ? (i == 0 || i == last ? 2.0 / 3.0 : 1.0) : 1.0;
         *entry(m, at, 4 * i + 2) = *entry(m, 4 * i + 2, at) = crank[d];
         if (i < last) {
            if (mass) *entry(m, at, at + 4) = *entry(m, at + 4, at) = 1.0 / 6.0;
            *entry(m, at, 4 * i + 3) = *entry(m, 4 * i + 3, at) = -rod[d];
            *entry(m, at + 4, 4 * i + 3) = *entry(m, 4 * i + 3, at + 4) = rod[d];
         }
      }
   }
   dgbsv_(&size, &k, &k, &one, m->band, &rows, m->pivot, m->work, &size, &info);
   return info;
}

static int loops_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   Model *m = data;
   int last = m->n;
   const double *y = N_VGetArrayPointer(vector), *v = y + 2 * (last + 1);
   double *rate = N_VGetArrayPointer(rate_vector), *force = m->work;
   loops_rods(m, y);
   for (int i = 0; i <= last; i++) {
      const double *crank = m->unit + 4 * i, *rod = crank + 2;
      double across = crank[0] * v[2 * i + 1] - crank[1] * v[2 * i];
      force[4 * i] = 0.0;
      force[4 * i + 1] = i == 0 || i == last ? -G : -1.5 * G;
      force[4 * i + 2] = -across * across / (1.0 + m->cosine[2 * i]);
      if (i == last) break;
      across = rod[0] * (v[2 * i + 3] - v[2 * i + 1]) - rod[1] * (v[2 * i + 2] - v[2 * i]);
      force[4 * i + 3] = -across * across / (1.0 + m->cosine[2 * i + 1]);
   }
   if (loops_solve(m, 1) != 0) return 1;
   for (int i = 0; i <= last; i++) {
      for (int d = 0; d < 2; d++) {
         rate[2 * i + d] = v[2 * i + d];
         rate[2 * (last + 1) + 2 * i + d] = m->work[4 * i + d];
      }
   }
   return 0;
}

static int loops_project(double t, N_Vector vector, void *data) {
   Model *m = data;
   int last = m->n;
   double *y = N_VGetArrayPointer(vector), *v = y + 2 * (last + 1), *x = m->work;
   for (int k = 0; loops_rods(m, y) > 1e-12; k++) {
      if (k == MAX_ITERATIONS) return 1;
      for (int i = 0; i <= last; i++) {
         x[4 * i] = x[4 * i + 1] = 0.0;
         x[4 * i + 2] = -m->cosine[2 * i];
         if (i < last) x[4 * i + 3] = -m->cosine[2 * i + 1];
      }
      if (loops_solve(m, 0) != 0) return 1;
      for (int i = 0; i <= last; i++)
         for (int d = 0; d < 2; d++) y[2 * i + d] += x[4 * i + d];
   }
   for (int i = 0; i <= last; i++) {
      x[4 * i] = v[2 * i];
      x[4 * i + 1] = v[2 * i + 1];
      x[4 * i + 2] = 0.0;
      if (i < last) x[4 * i + 3] = 0.0;
   }
   if (loops_solve(m, 0) != 0) return 1;
   for (int i = 0; i <= last; i++)
      for (int d = 0; d < 2; d++) v[2 * i + d] = x[4 * i + d];
   return 0;
}

static double now(void) {
   struct timespec time;
   clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
   return time.tv_sec + 1e-9 * time.tv_nsec;
}

static void check(int bad, const char *what) {
   if (!bad) return;
   fprintf(stderr, "sundials: %s\n", what);
   exit(1);
}

int main(int count, char **words) {
   if (count == 2 && strcmp(words[1], "--version") == 0) {
      char text[64];
      SUNDIALSGetVersion(text, sizeof text);
      puts(text);
      return 0;
   }
   check(count != 9, "arguments are PROBLEM SIZE METHOD RTOL ATOL MAX_STEP T_END SECONDS");
   int size = atoi(words[2]), length = 0;
   double rtol = atof(words[4]), atol = atof(words[5]), max_step = atof(words[6]), t_end = atof(words[7]);
   double seconds = atof(words[8]);
   Rates rates = NULL;
   Project project = NULL;
   if (strcmp(words[1], "pendulum") == 0) {
      length = 4;
      rates = pendulum_rates;
      project = pendulum_project;
   } else if (strcmp(words[1], "chain") == 0) {
      length = 4 * size;
      rates = chain_rates;
      project = chain_project;
   } else if (strcmp(words[1], "four-bar") == 0) {
      length = 4 * (size + 1);
      rates = loops_rates;
      project = loops_project;
   }
   check(rates == NULL, "there is no such problem");
   int room = 4 * (size + 1);
   Model model = {size, calloc(room, sizeof(double)), calloc(room, sizeof(double)), calloc(room, sizeof(double)),
                  calloc(room, sizeof(double)), calloc((long)room * ROWS, sizeof(double)), calloc(room, sizeof(int))};

   SUNContext context;
   check(SUNContext_Create(NULL, &context) != 0, "no context");
   N_Vector y = N_VNew_Serial(length, context), start = N_VNew_Serial(length, context);
   double *place = N_VGetArrayPointer(start);
   N_VConst(0.0, start);
   if (rates == pendulum_rates) place[0] = 1.0;
   if (rates == chain_rates)
      for (int i = 0; i < size; i++) place[2 * i] = i + 1.0;
   if (rates == loops_rates)
      for (int i = 0; i <= size; i++) {
         place[2 * i] = i;
         place[2 * i + 1] = place[2 * (size + 1) + 2 * i] = 1.0;
      }
   N_VScale(1.0, start, y);
   void *solver = ERKStepCreate(rates, 0.0, y, context);
   check(solver == NULL, "no solver");
   int bad = ERKStepSetUserData(solver, &model);
   bad |= ERKStepSetTableNum(solver, ARKODE_DORMAND_PRINCE_7_4_5);
   bad |= ERKStepSStolerances(solver, rtol, atol);
   bad |= ERKStepSetPostprocessStepFn(solver, project);
   bad |= ERKStepSetMaxNumSteps(solver, 10000000);
   if (max_step > 0.0) bad |= ERKStepSetMaxStep(solver, max_step);
   check(bad, "an option was refused");

   double best = 1e30, spent = 0.0;
   int repetitions = 1;
   long steps, rhs;
   do {
      double before = now();
      for (int k = 0; k < repetitions; k++) {
         double t;
         N_VScale(1.0, start, y);
         check(ERKStepReset(solver, 0.0, y), "no reset");
         check(ERKStepReInit(solver, rates, 0.0, y), "no start");
         check(ERKStepSetStopTime(solver, t_end), "no end");
         check(ERKStepEvolve(solver, t_end, y, &t, ARK_NORMAL) < 0, "the integration failed");
      }
      double taken = now() - before;
      spent += taken;
      if (taken / repetitions < best) best = taken / repetitions;
      repetitions = (int)fmin(10000.0, ceil(1e-3 / fmax(best, 1e-7)));
   } while (spent < seconds);
   ERKStepGetNumSteps(solver, &steps);
   ERKStepGetNumRhsEvals(solver, &rhs);
   printf("steps,rhs,seconds\n%ld,%ld,%.16e\n", steps, rhs, best);
   place = N_VGetArrayPointer(y);
   for (int i = 0; i < length; i++) printf("%.16e\n", place[i]);
   return 0;
}
