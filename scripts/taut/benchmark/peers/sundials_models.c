/* Problems that are not stiff, with accelerations and projections of O(n). */
#include "sundials_models.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void dgbsv_(int *n, int *kl, int *ku, int *nrhs, double *ab, int *ldab, int *ipiv, double *b, int *ldb, int *info);
void dgesv_(int *n, int *nrhs, double *a, int *lda, int *ipiv, double *b, int *ldb, int *info);

void *room(long count) {
   void *found = calloc(count, sizeof(double));
   if (found == NULL) {
      fprintf(stderr, "sundials: no memory\n");
      exit(1);
   }
   return found;
}

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
   for (int i = 0; i < m->size; i++) {
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
   for (int i = 1; i < m->size; i++) {
      c[i - 1] = -m->cosine[i] * pivot;
      pivot = 1.0 / (2.0 + m->cosine[i] * c[i - 1]);
      x[i] = (x[i] - x[i - 1] * -m->cosine[i]) * pivot;
   }
   for (int i = m->size - 2; i >= 0; i--) x[i] -= c[i] * x[i + 1];
}

/* y -= A^T right. */
static void chain_subtract(Model *m, double *y) {
   for (int i = 0; i < m->size; i++) {
      for (int k = 0; k < 2; k++) {
         double value = m->unit[2 * i + k] * m->right[i];
         y[2 * i + k] -= value;
         if (i > 0) y[2 * i - 2 + k] += value;
      }
   }
}

static int chain_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   Model *m = data;
   int n = m->size;
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
   double *y = N_VGetArrayPointer(vector), *v = y + 2 * m->size, limit = fmax(1e-12, 4.0 * 2.2e-16 * m->size);
   for (int k = 0; chain_rods(m, y) > limit; k++) {
      if (k == MAX_ITERATIONS) return -1;
      chain_solve(m);
      chain_subtract(m, y);
   }
   for (int i = 0; i < m->size; i++) {
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
   for (int i = 0; i <= m->size; i++) {
      for (int rod = 0; rod < 2 && !(rod && i == m->size); rod++) {
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
   int last = m->size, size = 4 * (m->size + 1) - 1, k = BAND, rows = ROWS, one = 1, info;
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
   int last = m->size;
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
   int last = m->size;
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

/* Heavy top about its tip, see problems/heavy_top.py: y = {quaternion; angular velocity in body axes}. */

#define TOP_ACROSS (0.234375 + 15.0)
#define TOP_ALONG 0.46875

static int top_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   const double *y = N_VGetArrayPointer(vector), *w = y + 4, a = y[0], b = y[1], c = y[2], d = y[3];
   double *rate = N_VGetArrayPointer(rate_vector), square = a * a + b * b + c * c + d * d;
   double up_1 = 2.0 * (b * d - a * c) / square, up_3 = (a * a - b * b - c * c + d * d) / square;
   rate[0] = -0.5 * (b * w[0] + c * w[1] + d * w[2]);
   rate[1] = 0.5 * (a * w[0] + c * w[2] - d * w[1]);
   rate[2] = 0.5 * (a * w[1] + d * w[0] - b * w[2]);
   rate[3] = 0.5 * (a * w[2] + b * w[1] - c * w[0]);
   rate[4] = (-15.0 * G * up_3 - (TOP_ACROSS - TOP_ALONG) * w[1] * w[2]) / TOP_ACROSS;
   rate[5] = 0.0;
   rate[6] = (15.0 * G * up_1 - (TOP_ALONG - TOP_ACROSS) * w[0] * w[1]) / TOP_ACROSS;
   return 0;
}

static int top_project(double t, N_Vector vector, void *data) {
   double *y = N_VGetArrayPointer(vector), scale = 1.0 / sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
   for (int k = 0; k < 4; k++) y[k] *= scale;
   return 0;
}

/* Andrews' mechanism, see problems/andrews.py: y = {beta, Theta, gamma, Phi, delta, Omega, epsilon; their rates}. */

#define ANGLES 7
#define LOOPS 6
#define BOTH (ANGLES + LOOPS)

static const double D = 28e-3, E = 2e-2, RR = 7e-3, SS = 35e-3, U = 4e-2, ZF = 2e-2, ZT = 4e-2;
static const double XA = -0.06934, YA = -0.00227, XB = -0.03635, YB = 0.03273;

/* Adds an arm that turns by the angles q_i and, where j is not negative, q_j to the loops from `first` to `last`. */
static void arm(double length, double angle, int i, int j, int first, int last, const double *v, double *open, double *a,
                double *bend) {
   double x = length * cos(angle), y = length * sin(angle), rate = v[i] + (j < 0 ? 0.0 : v[j]);
   for (int k = first; k <= last; k++) {
      open[2 * k] += x;
      open[2 * k + 1] += y;
      bend[2 * k] -= rate * rate * x;
      bend[2 * k + 1] -= rate * rate * y;
      a[2 * k * ANGLES + i] -= y;
      a[(2 * k + 1) * ANGLES + i] += x;
      if (j < 0) continue;
      a[2 * k * ANGLES + j] -= y;
      a[(2 * k + 1) * ANGLES + j] += x;
   }
}

static void squeezer_loops(const double *q, const double *v, double *open, double *a, double *bend) {
   static const double closed[LOOPS] = {XB, YB, XA, YA, XA, YA};
   const double quarter = 0.5 * 3.14159265358979323846;
   for (int i = 0; i < LOOPS; i++) open[i] = -closed[i];
   memset(a, 0, sizeof(double) * LOOPS * ANGLES);
   memset(bend, 0, sizeof(double) * LOOPS);
   arm(RR, q[0], 0, -1, 0, 2, v, open, a, bend);
   arm(-D, q[0] + q[1], 0, 1, 0, 2, v, open, a, bend);
   arm(SS, q[2] + quarter, 2, -1, 0, 0, v, open, a, bend);
   arm(E, q[3] + q[4] + quarter, 3, 4, 1, 1, v, open, a, bend);
   arm(-ZT, q[4], 4, -1, 1, 1, v, open, a, bend);
   arm(-ZF, q[5] + q[6], 5, 6, 2, 2, v, open, a, bend);
   arm(U, q[6] + quarter, 6, -1, 2, 2, v, open, a, bend);
}

/* right = [M A^T; A 0]^-1 right. */
static int squeezer_solve(const double *mass, const double *a, double *right) {
   double matrix[BOTH * BOTH] = {0};
   int pivot[BOTH], n = BOTH, one = 1, info;
   for (int i = 0; i < ANGLES; i++) memcpy(matrix + i * BOTH, mass + i * ANGLES, sizeof(double) * ANGLES);
   for (int k = 0; k < LOOPS; k++)
      for (int i = 0; i < ANGLES; i++) matrix[i * BOTH + ANGLES + k] = matrix[(ANGLES + k) * BOTH + i] = a[k * ANGLES + i];
   dgesv_(&n, &one, matrix, &n, pivot, right, &n, &info);
   return info;
}

static int squeezer_rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   const double m2 = 0.00365, m3 = 0.02373, m4 = 0.00706, m5 = 0.07050, m6 = 0.00706, m7 = 0.05498;
   const double i1 = 2.194e-6, i2 = 4.410e-7, i3 = 5.255e-6, i4 = 5.667e-7, i5 = 1.169e-5, i6 = 5.667e-7, i7 = 1.912e-5;
   const double da = 115e-4, ra = 92e-5, sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2;
   const double ta = 2308e-5, tb = 916e-5, ua = 1228e-5, ub = 449e-5, lever4 = E - 1421e-5, lever6 = ZF - 1421e-5;
   const double *q = N_VGetArrayPointer(vector), *v = q + ANGLES;
   double *rate = N_VGetArrayPointer(rate_vector), m[ANGLES][ANGLES] = {{0}};
   double open[LOOPS], a[LOOPS * ANGLES], bend[LOOPS], right[BOTH];

   double cosine = da * RR * cos(q[1]), sine = ZT * lever4 * sin(q[3]);
   m[0][0] = 0.04325 * ra * ra + m2 * (RR * RR - 2 * cosine + da * da) + i1 + i2;
   m[0][1] = m[1][0] = m2 * (da * da - cosine) + i2;
   m[1][1] = m2 * da * da + i2;
   m[2][2] = m3 * (sa * sa + sb * sb) + i3;
   m[3][3] = m4 * lever4 * lever4 + i4;
   m[3][4] = m[4][3] = m4 * (lever4 * lever4 + sine) + i4;
   m[4][4] = m4 * (ZT * ZT + 2 * sine + lever4 * lever4) + m5 * (ta * ta + tb * tb) + i4 + i5;
   sine = U * lever6 * sin(q[5]);
   m[5][5] = m6 * lever6 * lever6 + i6;
   m[5][6] = m[6][5] = m6 * (lever6 * lever6 - sine) + i6;
   m[6][6] = m6 * (lever6 * lever6 - 2 * sine + U * U) + m7 * (ua * ua + ub * ub) + i6 + i7;

   double to_x = sc * sin(q[2]) + sd * cos(q[2]), to_y = sd * sin(q[2]) - sc * cos(q[2]);
   double dx = to_x + XB - 0.014, dy = to_y + YB - 0.072, length = sqrt(dx * dx + dy * dy);
   double pull = -4530.0 * (length - 0.07785) / length;
   double swing2 = m2 * da * RR * sin(q[1]), swing4 = m4 * ZT * lever4 * cos(q[3]), swing6 = m6 * U * lever6 * cos(q[5]);
   right[0] = 0.033 - swing2 * v[1] * (v[1] + 2 * v[0]);
   right[1] = swing2 * v[0] * v[0];
   right[2] = pull * (dy * to_x - dx * to_y);
   right[3] = swing4 * v[4] * v[4];
   right[4] = -swing4 * v[3] * (v[3] + 2 * v[4]);
   right[5] = -swing6 * v[6] * v[6];
   right[6] = swing6 * v[5] * (v[5] + 2 * v[6]);
   squeezer_loops(q, v, open, a, bend);
   for (int k = 0; k < LOOPS; k++) right[ANGLES + k] = -bend[k];
   if (squeezer_solve(m[0], a, right) != 0) return 1;
   memcpy(rate, v, sizeof(double) * ANGLES);
   memcpy(rate + ANGLES, right, sizeof(double) * ANGLES);
   return 0;
}

static int squeezer_project(double t, N_Vector vector, void *data) {
   double *q = N_VGetArrayPointer(vector), *v = q + ANGLES, one[ANGLES * ANGLES] = {0};
   double open[LOOPS], a[LOOPS * ANGLES], bend[LOOPS], right[BOTH];
   for (int i = 0; i < ANGLES; i++) one[i * ANGLES + i] = 1.0;
   for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
      double worst = 0.0;
      squeezer_loops(q, v, open, a, bend);
      for (int k = 0; k < LOOPS; k++) worst = fmax(worst, fabs(open[k]));
      if (worst <= 1e-13) break;
      memset(right, 0, sizeof right);
      for (int k = 0; k < LOOPS; k++) right[ANGLES + k] = -open[k];
      if (squeezer_solve(one, a, right) != 0) return 1;
      for (int i = 0; i < ANGLES; i++) q[i] += right[i];
   }
   memset(right, 0, sizeof right);
   memcpy(right, v, sizeof(double) * ANGLES);
   if (squeezer_solve(one, a, right) != 0) return 1;
   memcpy(v, right, sizeof(double) * ANGLES);
   return 0;
}

int explicit_model(const char *name, int size, Model *m) {
   m->size = size;
   if (strcmp(name, "pendulum") == 0) {
      m->length = 4;
      m->rates = pendulum_rates;
      m->project = pendulum_project;
   } else if (strcmp(name, "chain") == 0) {
      m->length = 4 * size;
      m->rates = chain_rates;
      m->project = chain_project;
   } else if (strcmp(name, "four-bar") == 0) {
      m->length = 4 * (size + 1);
      m->rates = loops_rates;
      m->project = loops_project;
   } else if (strcmp(name, "heavy_top") == 0) {
      m->length = 7;
      m->rates = top_rates;
      m->project = top_project;
   } else if (strcmp(name, "andrews") == 0) {
      m->length = 2 * ANGLES;
      m->rates = squeezer_rates;
      m->project = squeezer_project;
   } else
      return 0;

   long some = 4 * (size + 1);
   m->unit = room(some);
   m->cosine = room(some);
   m->right = room(some);
   m->work = room(some);
   m->band = room(some * ROWS);
   m->pivot = room(some);
   double *start = m->start = room(m->length);
   if (m->rates == pendulum_rates) start[0] = 1.0;
   if (m->rates == chain_rates)
      for (int i = 0; i < size; i++) start[2 * i] = i + 1.0;
   if (m->rates == loops_rates)
      for (int i = 0; i <= size; i++) {
         start[2 * i] = i;
         start[2 * i + 1] = start[2 * (size + 1) + 2 * i] = 1.0;
      }
   if (m->rates == top_rates) {
      start[0] = 1.0;
      start[5] = 150.0;
      start[6] = -4.61538;
   }
   if (m->rates == squeezer_rates) {
      double angles[ANGLES] = {-0.0617138900142764496358948458001, 0.0, 0.455279819163070380255912382449,
                               0.222668390165885884674473185609, 0.487364979543842550225598953530,
                               -0.222668390165885884674473185609, 1.23054744454982119249735015568};
      memcpy(start, angles, sizeof angles);
   }
   return 1;
}
