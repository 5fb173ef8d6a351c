/* The problems for SUNDIALS, by hand: y = {x; v}, or what stands above each. */
#ifndef SUNDIALS_MODELS_H
#define SUNDIALS_MODELS_H
#include <nvector/nvector_serial.h>

#define G 9.81
#define MAX_ITERATIONS 25

typedef struct Model Model;

/* Rates of y, and its projection on the constraints; both for SUNDIALS, `data` is the Model. */
typedef int (*Rates)(double t, N_Vector y, N_Vector rate, void *data);
typedef int (*Project)(double t, N_Vector y, void *data);

/* Forces, constraints, A (row after row), b' and b'' of a system with a diagonal mass matrix. */
typedef void (*Terms)(const Model *m, double t, const double *x, const double *v, double *force, double *phi, double *a,
                      double *velocity_rhs, double *acceleration_rhs);

struct Model {
   int size;   /* rods, loops, powers of ten, elements */
   int length; /* of y */
   Rates rates;
   Project project; /* NULL: there are no constraints */
   double *start;
   /* Rods' directions, their products, right side, and what the solution needs. */
   double *unit, *cosine, *right, *work, *band;
   int *pivot;
   /* Where `terms` is not NULL: coordinates, constraints, masses. */
   int n, c;
   Terms terms;
   double *mass;
};

/* Makes a model; returns 0 where there is none of that name. */
int explicit_model(const char *name, int size, Model *m);
int stiff_model(const char *name, int size, Model *m);

/* Accelerations and multipliers of a model with `terms`; returns what went wrong, or 0. */
int accelerate(Model *m, double t, const double *x, const double *v, double *acceleration, double *lambda);

void *room(long count);

#endif
