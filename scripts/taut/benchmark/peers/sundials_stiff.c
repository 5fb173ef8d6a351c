/* Problems with stiff springs, as M vdot + A^T lambda = f, phi(x, t) = 0 with a diagonal M. */
#include "sundials_models.h"
#include <math.h>
#include <string.h>

#define MOST 8 /* constraints */

void dgesv_(int *n, int *nrhs, double *a, int *lda, int *ipiv, double *b, int *ldb, int *info);

/* right = (A W A^T)^-1 right, W the inverse of the masses or one. */
static int solve(const Model *m, const double *a, int mass, double *right) {
   double s[MOST * MOST];
   int pivot[MOST], one = 1, c = m->c, info = 0;
   for (int i = 0; i < c; i++)
      for (int j = 0; j < c; j++) {
         double sum = 0.0;
         for (int k = 0; k < m->n; k++) sum += a[i * m->n + k] * a[j * m->n + k] / (mass ? m->mass[k] : 1.0);
         s[j * c + i] = sum;
      }
   if (c > 0) dgesv_(&c, &one, s, &c, pivot, right, &c, &info);
   return info;
}

int accelerate(Model *m, double t, const double *x, const double *v, double *acceleration, double *lambda) {
   double phi[MOST], b[MOST], *a = m->work;
   m->terms(m, t, x, v, acceleration, phi, a, b, lambda);
   for (int k = 0; k < m->n; k++) acceleration[k] /= m->mass[k];
   for (int i = 0; i < m->c; i++) {
      lambda[i] = -lambda[i];
      for (int k = 0; k < m->n; k++) lambda[i] += a[i * m->n + k] * acceleration[k];
   }
   int info = solve(m, a, 1, lambda);
   for (int i = 0; i < m->c; i++)
      for (int k = 0; k < m->n; k++) acceleration[k] -= a[i * m->n + k] * lambda[i] / m->mass[k];
   return info;
}

static int rates(double t, N_Vector vector, N_Vector rate_vector, void *data) {
   Model *m = data;
   const double *y = N_VGetArrayPointer(vector);
   double *rate = N_VGetArrayPointer(rate_vector), lambda[MOST];
   memcpy(rate, y + m->n, sizeof(double) * m->n);
   return accelerate(m, t, y, y + m->n, rate + m->n, lambda);
}

static int project(double t, N_Vector vector, void *data) {
   Model *m = data;
   int n = m->n;
   double *x = N_VGetArrayPointer(vector), *v = x + n, *a = m->work, phi[MOST], b[MOST], unused[MOST];
   for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
      double worst = 0.0;
      m->terms(m, t, x, v, m->right, phi, a, b, unused);
      for (int i = 0; i < m->c; i++) worst = fmax(worst, fabs(phi[i]));
      if (worst <= 1e-12) break;
      if (solve(m, a, 0, phi) != 0) return 1;
      for (int i = 0; i < m->c; i++)
         for (int k = 0; k < n; k++) x[k] -= a[i * n + k] * phi[i];
   }
   for (int i = 0; i < m->c; i++) {
      phi[i] = -b[i];
      for (int k = 0; k < n; k++) phi[i] += a[i * n + k] * v[k];
   }
   if (solve(m, a, 0, phi) != 0) return 1;
   for (int i = 0; i < m->c; i++)
      for (int k = 0; k < n; k++) v[k] -= a[i * n + k] * phi[i];
   return 0;
}

/* A mass of 1 kg on a spring of 10^size N/m. */
static void spring_terms(const Model *m, double t, const double *x, const double *v, double *force, double *phi, double *a,
                         double *velocity_rhs, double *acceleration_rhs) {
   double length = sqrt(x[0] * x[0] + x[1] * x[1]), pull = pow(10.0, m->size) * (length - 1.0) / length;
   force[0] = -pull * x[0];
   force[1] = -pull * x[1] - G;
}

/* The car axis, see problems/car_axis.py: {x_l, y_l, x_r, y_r}. */
#define K 5e-4
#define FREE 0.5

static void axis_terms(const Model *m, double t, const double *x, const double *v, double *force, double *phi, double *a,
                       double *velocity_rhs, double *acceleration_rhs) {
   double sine = sin(10.0 * t), yb = 0.1 * sine, vb = cos(10.0 * t), ab = -10.0 * sine;
   double xb = sqrt(1.0 - yb * yb), ub = -yb * vb / xb, cb = -(vb * vb + yb * ab + ub * ub) / xb;
   double rx = x[2] - xb, ry = x[3] - yb;
   double left = FREE / sqrt(x[0] * x[0] + x[1] * x[1]) - 1.0, right = FREE / sqrt(rx * rx + ry * ry) - 1.0;
   double dx = x[0] - x[2], dy = x[1] - x[3], du = v[0] - v[2], dv = v[1] - v[3];
   force[0] = left * x[0];
   force[1] = left * x[1] - K;
   force[2] = right * rx;
   force[3] = right * ry - K;
   phi[0] = x[0] * xb + x[1] * yb;
   phi[1] = dx * dx + dy * dy - 1.0;
   double rows[8] = {xb, yb, 0.0, 0.0, 2 * dx, 2 * dy, -2 * dx, -2 * dy};
   memcpy(a, rows, sizeof rows);
   velocity_rhs[0] = -(x[0] * ub + x[1] * vb);
   velocity_rhs[1] = 0.0;
   acceleration_rhs[0] = -2.0 * (v[0] * ub + v[1] * vb) - (x[0] * cb + x[1] * ab);
   acceleration_rhs[1] = -2.0 * (du * du + dv * dv);
}

/* The paper's swing in its plane, of geometrically exact elements with one point each: {x, y, angle} of every node. */
static const double length = 0.72, thickness = 1e-3, width = 5e-3, young = 73e9, poisson = 0.3, density = 2700.0;
static const double corner[2][2] = {{0.0, 0.36}, {1.08, 0.36}};

static void swing_terms(const Model *m, double t, const double *x, const double *v, double *force, double *phi, double *a,
                        double *velocity_rhs, double *acceleration_rhs) {
   int n = m->n, last = m->size;
   double area = thickness * width, l = length / last;
   double axial = young * area, shear = 5.0 / 6.0 * young / (2.0 * (1.0 + poisson)) * area;
   double bending = young * width * pow(thickness, 3) / 12.0;
   memset(force, 0, sizeof(double) * n);
   for (int i = 0; i < last; i++) {
      const double *one = x + 3 * i, *two = one + 3;
      double turned = 0.5 * (one[2] + two[2]), c = cos(turned), s = sin(turned);
      double dx = two[0] - one[0], dy = two[1] - one[1];
      double normal = axial * ((c * dx + s * dy) / l - 1.0), across = shear * (c * dy - s * dx) / l;
      double fx = c * normal - s * across, fy = s * normal + c * across;
      double half = 0.5 * (dx * fy - dy * fx), moment = bending * (two[2] - one[2]) / l;
      double *f = force + 3 * i;
      f[0] += fx;
      f[1] += fy;
      f[2] += half + moment;
      f[3] -= fx;
      f[4] -= fy;
      f[5] += half - moment;
   }
   force[3 * (last / 2)] += 2.0 * fmax(0.0, 1.0 - fabs(t / 0.128 - 1.0));
   memset(a, 0, sizeof(double) * 2 * n);
   for (int i = 0; i < 2; i++) {
      int at = i * 3 * last;
      double dx = x[at] - corner[i][0], dy = x[at + 1] - corner[i][1], r = sqrt(dx * dx + dy * dy);
      double ex = dx / r, ey = dy / r, turning = ex * v[at + 1] - ey * v[at];
      phi[i] = r - (i == 0 ? 0.36 : 0.36 * sqrt(2.0));
      a[i * n + at] = ex;
      a[i * n + at + 1] = ey;
      velocity_rhs[i] = 0.0;
      acceleration_rhs[i] = -turning * turning / r;
   }
}

int stiff_model(const char *name, int size, Model *m) {
   m->size = size;
   if (strcmp(name, "spring") == 0) {
      m->n = 2;
      m->c = 0;
      m->terms = spring_terms;
   } else if (strcmp(name, "car-axis") == 0) {
      m->n = 4;
      m->c = 2;
      m->terms = axis_terms;
   } else if (strcmp(name, "swing") == 0) {
      m->n = 3 * (size + 1);
      m->c = 2;
      m->terms = swing_terms;
   } else
      return 0;
   m->length = 2 * m->n;
   m->rates = rates;
   m->project = m->c > 0 ? project : NULL;
   m->start = room(m->length);
   m->mass = room(m->n);
   m->right = room(m->n);
   m->work = room(MOST * m->n);
   if (m->terms == spring_terms) {
      m->start[0] = 1.0;
      m->mass[0] = m->mass[1] = 1.0;
   } else if (m->terms == axis_terms) {
      double start[8] = {0.0, FREE, 1.0, FREE, -FREE, 0.0, -FREE, 0.0};
      memcpy(m->start, start, sizeof start);
      for (int k = 0; k < 4; k++) m->mass[k] = K;
   } else {
      double l = length / size, half = 0.5 * density * thickness * width * l;
      double turning = 0.5 * density * width * pow(thickness, 3) / 12.0 * l + half * l * l / 12.0;
      for (int i = 0; i <= size; i++) {
         int ends = i == 0 || i == size ? 1 : 2;
         m->start[3 * i] = i * l;
         m->mass[3 * i] = m->mass[3 * i + 1] = ends * half + (i == size / 2 ? 0.5 : 0.0);
         m->mass[3 * i + 2] = ends * turning;
      }
   }
   return 1;
}
