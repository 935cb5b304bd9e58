/* Ball on a rigid floor without losses; mass on a moving belt that sticks and slips. */
#include "events.h"

static const double GRAVITY = 9.81, HEIGHT = 1.0;
static const double MASS = 1, STIFFNESS = 100, STICKING = 12, SLIPPING = 8, BELT = 0.2;

/* Ball: height, velocity. */
static int ball_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr);
  (void)t;
  ((Machine *)user)->residuals++;
  r[0] = yp[0] - y[1];
  r[1] = yp[1] + GRAVITY;
  return 0;
}

static int ball_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                         void *user, N_Vector a, N_Vector b, N_Vector c) {
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  ((Machine *)user)->jacobians++;
  column(&m), entry(&m, 0, cj);
  column(&m), entry(&m, 0, -1), entry(&m, 1, cj);
  finish(&m);
  return 0;
}

static int ball_root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  (void)t, (void)yyp;
  ((Machine *)user)->roots++;
  g[0] = N_VGetArrayPointer(yy)[0];
  return 0;
}

static void ball_start(Machine *machine, double *y, double *yp) {
  machine->direction[0] = -1;
  y[0] = HEIGHT, y[1] = 0, yp[0] = 0, yp[1] = -GRAVITY;
}

static void both_differential(const Machine *machine, double *id) {
  (void)machine;
  id[0] = id[1] = 1;
}

static void ball_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)machine, (void)t, (void)crossed;
  y[0] = 0;
  yp[0] = y[1] = -y[1];
}

EventProblem ball_problem(void) {
  EventProblem p = {"ball", 2, 3, 1, 900, 1, ball_residual, ball_jacobian, ball_root,
                    ball_start, both_differential, ball_event};
  return p;
}

/* Stick and slip: position, velocity. Mode 1 is stuck. */
static int stick_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr);
  (void)t;
  machine->residuals++;
  r[0] = yp[0] - y[1];
  r[1] = machine->mode ? yp[1] : MASS * yp[1] + STIFFNESS * y[0] - SLIPPING;
  return 0;
}

static int stick_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                          void *user, N_Vector a, N_Vector b, N_Vector c) {
  Machine *machine = user;
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  machine->jacobians++;
  column(&m), entry(&m, 0, cj), entry(&m, 1, machine->mode ? 0 : STIFFNESS);
  column(&m), entry(&m, 0, -1), entry(&m, 1, machine->mode ? cj : MASS * cj);
  finish(&m);
  return 0;
}

static int stick_root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy);
  (void)t, (void)yyp;
  machine->roots++;
  g[0] = machine->mode ? STIFFNESS * y[0] - STICKING : y[1] - BELT;
  return 0;
}

static void stick_start(Machine *machine, double *y, double *yp) {
  machine->mode = machine->direction[0] = 1;
  y[0] = 0, y[1] = yp[0] = BELT, yp[1] = 0;
}

static void stick_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)t, (void)crossed;
  machine->mode = !machine->mode;
  if (machine->mode) y[1] = BELT;
  yp[0] = y[1];
  yp[1] = machine->mode ? 0 : (SLIPPING - STIFFNESS * y[0]) / MASS;
}

EventProblem stick_slip_problem(void) {
  EventProblem p = {"stick_slip", 2, 4, 1, 500, 1, stick_residual, stick_jacobian, stick_root,
                    stick_start, both_differential, stick_event};
  return p;
}
