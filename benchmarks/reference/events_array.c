/* A line of cells: resistor to the cell before, capacitor and leak to ground, and a clamp that
 * conducts above a voltage that is never reached: one relation per cell, and no event. */
#include "events.h"

static const double R = 1, C = 1e-3, LEAK = 0.01, LIMIT = 2, FREQUENCY = 50;

static int residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr), left = sin(2 * M_PI * FREQUENCY * t);
  sunindextype last = machine->size - 1;
  machine->residuals++;
  for (sunindextype k = 0; k <= last; k++) {
    double onward = k < last ? (y[k] - y[k + 1]) / R : 0;
    r[k] = C * yp[k] - (left - y[k]) / R + onward + LEAK * y[k];
    left = y[k];
  }
  return 0;
}

static int jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                    void *user, N_Vector a, N_Vector b, N_Vector c) {
  Machine *machine = user;
  Columns m = columns_of(J);
  sunindextype last = machine->size - 1;
  (void)t, (void)yy, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  machine->jacobians++;
  for (sunindextype k = 0; k <= last; k++) {
    column(&m);
    if (k > 0) entry(&m, k - 1, -1 / R);
    entry(&m, k, C * cj + 1 / R + LEAK + (k < last ? 1 / R : 0));
    if (k < last) entry(&m, k + 1, -1 / R);
  }
  finish(&m);
  return 0;
}

static int root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy);
  (void)t, (void)yyp;
  machine->roots++;
  for (sunindextype k = 0; k < machine->size; k++) g[k] = y[k] - LIMIT;
  return 0;
}

static void start(Machine *machine, double *y, double *yp) {
  for (sunindextype k = 0; k < machine->size; k++) y[k] = yp[k] = 0;
}

static void differential(const Machine *machine, double *id) {
  for (sunindextype k = 0; k < machine->size; k++) id[k] = 1;
}

/* Never called: the clamps stay off. */
static void event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)machine, (void)t, (void)crossed, (void)y, (void)yp;
}

EventProblem array_problem(sunindextype cells, int relations) {
  EventProblem p = {"array", cells, 3 * cells - 2, relations ? (int)cells : 0, 0.1, 0.01,
                    residual, jacobian, root, start, differential, event};
  return p;
}
