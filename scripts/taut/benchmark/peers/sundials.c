/* Integrators of SUNDIALS on models by hand; arguments and output are those of program/taut_benchmark.f90. METHOD is
 *   erk   ARKODE's ERKStep with the method of Dormand and Prince,
 *   erk8  ERKStep of order 8, the library's own choice (Fehlberg's 8(7) in 6.4),
 *   dirk  ARKODE's ARKStep, implicit, of order 5 (Kennedy and Carpenter),
 *   ida   IDA on the form with two multipliers (Gear, Gupta, Leimkuhler; index 2), for models with `terms`.
 * Position and velocity are projected after each step of the first three by the ...SetPostprocessStepFn of the library. Jacobians
 * are dense and by differences. */
#include "sundials_models.h"
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <ida/ida.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <time.h>

#define MAX_STEPS 10000000

typedef struct {
   double rtol, atol, max_step, t_end;
} Options;

typedef struct {
   void *memory;
   Model *model;
   Options options;
   N_Vector start, y, rate, start_rate;
   SUNMatrix matrix;
   SUNLinearSolver linear;
} Solver;

typedef struct {
   long steps, rhs, jacobians;
} Counts;

/* Makes a solver, integrates once from the start, and counts. */
typedef struct {
   const char *name;
   int (*make)(Solver *, SUNContext);
   int (*run)(Solver *);
   void (*count)(const Solver *, Counts *);
} Method;

static void check(int bad, const char *what) {
   if (!bad) return;
   fprintf(stderr, "sundials: %s\n", what);
   exit(1);
}

static int make_erk_of(Solver *s, SUNContext context, int order) {
   s->memory = ERKStepCreate(s->model->rates, 0.0, s->y, context);
   if (s->memory == NULL) return 1;
   int bad = ERKStepSetUserData(s->memory, s->model);
   bad |= order == 5 ? ERKStepSetTableNum(s->memory, ARKODE_DORMAND_PRINCE_7_4_5) : ERKStepSetOrder(s->memory, order);
   bad |= ERKStepSStolerances(s->memory, s->options.rtol, s->options.atol);
   if (s->model->project != NULL) bad |= ERKStepSetPostprocessStepFn(s->memory, s->model->project);
   bad |= ERKStepSetMaxNumSteps(s->memory, MAX_STEPS);
   if (s->options.max_step > 0.0) bad |= ERKStepSetMaxStep(s->memory, s->options.max_step);
   return bad;
}

static int make_erk(Solver *s, SUNContext context) { return make_erk_of(s, context, 5); }

static int make_erk8(Solver *s, SUNContext context) { return make_erk_of(s, context, 8); }

static int run_erk(Solver *s) {
   double t;
   N_VScale(1.0, s->start, s->y);
   if (ERKStepReset(s->memory, 0.0, s->y) || ERKStepReInit(s->memory, s->model->rates, 0.0, s->y)) return 1;
   return ERKStepSetStopTime(s->memory, s->options.t_end) ||
          ERKStepEvolve(s->memory, s->options.t_end, s->y, &t, ARK_NORMAL) < 0;
}

static void count_erk(const Solver *s, Counts *counts) {
   ERKStepGetNumSteps(s->memory, &counts->steps);
   ERKStepGetNumRhsEvals(s->memory, &counts->rhs);
}

static void make_dense(Solver *s, SUNContext context) {
   long length = N_VGetLength(s->y);
   s->matrix = SUNDenseMatrix(length, length, context);
   s->linear = SUNLinSol_Dense(s->y, s->matrix, context);
}

static int make_dirk(Solver *s, SUNContext context) {
   s->memory = ARKStepCreate(NULL, s->model->rates, 0.0, s->y, context);
   if (s->memory == NULL) return 1;
   make_dense(s, context);
   int bad = ARKStepSetUserData(s->memory, s->model);
   bad |= ARKStepSetOrder(s->memory, 5);
   bad |= ARKStepSStolerances(s->memory, s->options.rtol, s->options.atol);
   bad |= ARKStepSetLinearSolver(s->memory, s->linear, s->matrix);
   if (s->model->project != NULL) bad |= ARKStepSetPostprocessStepFn(s->memory, s->model->project);
   bad |= ARKStepSetMaxNumSteps(s->memory, MAX_STEPS);
   if (s->options.max_step > 0.0) bad |= ARKStepSetMaxStep(s->memory, s->options.max_step);
   return bad;
}

static int run_dirk(Solver *s) {
   double t;
   N_VScale(1.0, s->start, s->y);
   if (ARKStepReset(s->memory, 0.0, s->y) || ARKStepReInit(s->memory, NULL, s->model->rates, 0.0, s->y)) return 1;
   return ARKStepSetStopTime(s->memory, s->options.t_end) ||
          ARKStepEvolve(s->memory, s->options.t_end, s->y, &t, ARK_NORMAL) < 0;
}

static void count_dirk(const Solver *s, Counts *counts) {
   long explicit_ones, differences;
   ARKStepGetNumSteps(s->memory, &counts->steps);
   ARKStepGetNumRhsEvals(s->memory, &explicit_ones, &counts->rhs);
   ARKStepGetNumLinRhsEvals(s->memory, &differences);
   counts->rhs += differences;
   ARKStepGetNumJacEvals(s->memory, &counts->jacobians);
}

/* {x' - v + A^T mu; M v' - f + A^T lambda; A v - b'; phi}, y = {x, v, lambda, mu}. */
static int residual(double t, N_Vector vector, N_Vector rate_vector, N_Vector residual_vector, void *data) {
   Model *m = data;
   int n = m->n, c = m->c;
   const double *x = N_VGetArrayPointer(vector), *v = x + n, *lambda = v + n, *mu = lambda + c;
   const double *rate = N_VGetArrayPointer(rate_vector);
   double *r = N_VGetArrayPointer(residual_vector), *b = r + 2 * n, *phi = b + c, *a = m->work;
   m->terms(m, t, x, v, m->right, phi, a, b, r);
   for (int k = 0; k < n; k++) {
      r[k] = rate[k] - v[k];
      r[n + k] = m->mass[k] * rate[n + k] - m->right[k];
   }
   for (int i = 0; i < c; i++) {
      b[i] = -b[i];
      for (int k = 0; k < n; k++) {
         r[k] += a[i * n + k] * mu[i];
         r[n + k] += a[i * n + k] * lambda[i];
         b[i] += a[i * n + k] * v[k];
      }
   }
   return 0;
}

static int make_ida(Solver *s, SUNContext context) {
   Model *m = s->model;
   if (m->terms == NULL) return 1;
   int n = m->n;
   N_Vector kind = N_VNew_Serial(2 * n + 2 * m->c, context);
   s->y = N_VClone(kind);
   s->rate = N_VClone(kind);
   s->start_rate = N_VClone(kind);
   s->start = N_VClone(kind);
   N_VConst(0.0, kind);
   N_VConst(0.0, s->start);
   N_VConst(0.0, s->start_rate);
   double *start = N_VGetArrayPointer(s->start), *rate = N_VGetArrayPointer(s->start_rate);
   for (int k = 0; k < 2 * n; k++) {
      N_VGetArrayPointer(kind)[k] = 1.0;
      start[k] = m->start[k];
   }
   memcpy(rate, start + n, sizeof(double) * n);
   if (accelerate(m, 0.0, start, start + n, rate + n, start + 2 * n) != 0) return 1;
   N_VScale(1.0, s->start, s->y);
   s->memory = IDACreate(context);
   if (s->memory == NULL) return 1;
   make_dense(s, context);
   int bad = IDAInit(s->memory, residual, 0.0, s->start, s->start_rate);
   bad |= IDASetUserData(s->memory, m);
   bad |= IDASStolerances(s->memory, s->options.rtol, s->options.atol);
   bad |= IDASetLinearSolver(s->memory, s->linear, s->matrix);
   bad |= IDASetId(s->memory, kind);
   bad |= IDASetSuppressAlg(s->memory, SUNTRUE);
   bad |= IDASetMaxNumSteps(s->memory, MAX_STEPS);
   if (s->options.max_step > 0.0) bad |= IDASetMaxStep(s->memory, s->options.max_step);
   return bad;
}

static int run_ida(Solver *s) {
   double t;
   N_VScale(1.0, s->start, s->y);
   N_VScale(1.0, s->start_rate, s->rate);
   if (IDAReInit(s->memory, 0.0, s->y, s->rate) || IDASetStopTime(s->memory, s->options.t_end)) return 1;
   return IDASolve(s->memory, s->options.t_end, &t, s->y, s->rate, IDA_NORMAL) < 0;
}

static void count_ida(const Solver *s, Counts *counts) {
   long differences;
   IDAGetNumSteps(s->memory, &counts->steps);
   IDAGetNumResEvals(s->memory, &counts->rhs);
   IDAGetNumLinResEvals(s->memory, &differences);
   counts->rhs += differences;
   IDAGetNumJacEvals(s->memory, &counts->jacobians);
}

static const Method methods[] = {
   {"erk", make_erk, run_erk, count_erk},
   {"erk8", make_erk8, run_erk, count_erk},
   {"dirk", make_dirk, run_dirk, count_dirk},
   {"ida", make_ida, run_ida, count_ida},
};

static double now(void) {
   struct timespec time;
   clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
   return time.tv_sec + 1e-9 * time.tv_nsec;
}

int main(int count, char **words) {
   if (count == 2 && strcmp(words[1], "--version") == 0) {
      char text[64];
      SUNDIALSGetVersion(text, sizeof text);
      puts(text);
      return 0;
   }
   check(count != 9, "arguments are PROBLEM SIZE METHOD RTOL ATOL MAX_STEP T_END SECONDS");
   Model model = {0};
   check(!explicit_model(words[1], atoi(words[2]), &model) && !stiff_model(words[1], atoi(words[2]), &model),
         "there is no such problem");
   const Method *method = NULL;
   for (size_t i = 0; i < sizeof methods / sizeof *methods; i++)
      if (strcmp(words[3], methods[i].name) == 0) method = methods + i;
   check(method == NULL, "there is no such method");
   double seconds = atof(words[8]);

   SUNContext context;
   check(SUNContext_Create(NULL, &context) != 0, "no context");
   Solver solver = {.model = &model, .options = {atof(words[4]), atof(words[5]), atof(words[6]), atof(words[7])}};
   solver.y = N_VNew_Serial(model.length, context);
   solver.start = N_VNew_Serial(model.length, context);
   memcpy(N_VGetArrayPointer(solver.start), model.start, sizeof(double) * model.length);
   N_VScale(1.0, solver.start, solver.y);
   check(method->make(&solver, context), "an option was refused");

   double best = 1e30, spent = 0.0;
   int repetitions = 1;
   do {
      double before = now();
      for (int k = 0; k < repetitions; k++) check(method->run(&solver), "the integration failed");
      double taken = now() - before;
      spent += taken;
      if (taken / repetitions < best) best = taken / repetitions;
      repetitions = (int)fmin(10000.0, ceil(1e-3 / fmax(best, 1e-7)));
   } while (spent < seconds);
   Counts counts = {0};
   method->count(&solver, &counts);
   printf("steps,rhs,jacobians,seconds\n%ld,%ld,%ld,%.16e\n", counts.steps, counts.rhs, counts.jacobians, best);
   double *last = N_VGetArrayPointer(solver.y);
   for (int i = 0; i < model.length; i++) printf("%.16e\n", last[i]);
   return 0;
}
