/* Circuits with ideal diodes and switches. A diode has the parameter s: off v = s, i = G_OFF s; on
 * v = R_ON s, i = s. It changes its state where s changes its sign, and nothing jumps there. */
#include "events.h"

static const double R_ON = 1e-5, G_OFF = 1e-5;
static const double AMPLITUDE = 10, FREQUENCY = 50, R_SOURCE = 1, C_SMOOTH = 1e-3, R_LOAD = 100;

static double flow(int on, double s) { return on ? s : G_OFF * s; }
static double drop(int on, double s) { return on ? R_ON * s : s; }
static double sine(double t) { return AMPLITUDE * sin(2 * M_PI * FREQUENCY * t); }

static void first_differential(const Machine *machine, double *id) {
  (void)machine;
  id[0] = 1, id[1] = 0;
}

/* Half wave: capacitor voltage, parameter of the diode. */
static int half_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr), i = flow(machine->mode, y[1]);
  machine->residuals++;
  r[0] = C_SMOOTH * yp[0] + y[0] / R_LOAD - i;
  r[1] = R_SOURCE * i + drop(machine->mode, y[1]) + y[0] - sine(t);
  return 0;
}

static int half_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                         void *user, N_Vector a, N_Vector b, N_Vector c) {
  Machine *machine = user;
  double di = flow(machine->mode, 1);
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  machine->jacobians++;
  column(&m), entry(&m, 0, C_SMOOTH * cj + 1 / R_LOAD), entry(&m, 1, 1);
  column(&m), entry(&m, 0, -di), entry(&m, 1, R_SOURCE * di + drop(machine->mode, 1));
  finish(&m);
  return 0;
}

static int half_root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  (void)t, (void)yyp;
  ((Machine *)user)->roots++;
  g[0] = N_VGetArrayPointer(yy)[1];
  return 0;
}

static void half_settle(Machine *machine, double t, double *y, double *yp) {
  double resistance = R_SOURCE * flow(machine->mode, 1) + drop(machine->mode, 1);
  machine->direction[0] = machine->mode ? -1 : 1;
  y[1] = (sine(t) - y[0]) / resistance;
  yp[0] = (flow(machine->mode, y[1]) - y[0] / R_LOAD) / C_SMOOTH;
  yp[1] = (AMPLITUDE * 2 * M_PI * FREQUENCY * cos(2 * M_PI * FREQUENCY * t) - yp[0]) / resistance;
}

static void half_start(Machine *machine, double *y, double *yp) {
  machine->mode = 1;
  y[0] = 0;
  half_settle(machine, 0, y, yp);
}

static void half_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)crossed;
  machine->mode = !machine->mode;
  half_settle(machine, t, y, yp);
}

EventProblem half_wave_problem(void) {
  EventProblem p = {"half_wave", 2, 4, 1, 20, 0.01, half_residual, half_jacobian, half_root,
                    half_start, first_differential, half_event};
  return p;
}

/* Bridge: capacitor voltage, parameters of the diodes a-plus, b-plus, 0-a, 0-b, source current,
 * potentials of a and b. Diodes 1 and 4 change together, so do 2 and 3: modes `mode`, `second`. */
static int bridge_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr), v = y[0], i = y[5], a = y[6], b = y[7];
  int p = machine->mode, q = machine->second;
  machine->residuals++;
  r[0] = C_SMOOTH * yp[0] + v / R_LOAD - flow(p, y[1]) - flow(q, y[2]);
  r[1] = drop(p, y[1]) - a + v;
  r[2] = drop(q, y[2]) - b + v;
  r[3] = drop(q, y[3]) + a;
  r[4] = drop(p, y[4]) + b;
  r[5] = i - flow(p, y[1]) + flow(q, y[3]);
  r[6] = -i - flow(q, y[2]) + flow(p, y[4]);
  r[7] = R_SOURCE * i + a - b - sine(t);
  return 0;
}

static int bridge_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                           void *user, N_Vector n1, N_Vector n2, N_Vector n3) {
  Machine *machine = user;
  double ip = flow(machine->mode, 1), vp = drop(machine->mode, 1);
  double iq = flow(machine->second, 1), vq = drop(machine->second, 1);
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)n1, (void)n2, (void)n3;
  machine->jacobians++;
  column(&m), entry(&m, 0, C_SMOOTH * cj + 1 / R_LOAD), entry(&m, 1, 1), entry(&m, 2, 1);
  column(&m), entry(&m, 0, -ip), entry(&m, 1, vp), entry(&m, 5, -ip);
  column(&m), entry(&m, 0, -iq), entry(&m, 2, vq), entry(&m, 6, -iq);
  column(&m), entry(&m, 3, vq), entry(&m, 5, iq);
  column(&m), entry(&m, 4, vp), entry(&m, 6, ip);
  column(&m), entry(&m, 5, 1), entry(&m, 6, -1), entry(&m, 7, R_SOURCE);
  column(&m), entry(&m, 1, -1), entry(&m, 3, 1), entry(&m, 7, 1);
  column(&m), entry(&m, 2, -1), entry(&m, 4, 1), entry(&m, 7, -1);
  finish(&m);
  return 0;
}

static int bridge_root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  const double *y = N_VGetArrayPointer(yy);
  (void)t, (void)yyp;
  ((Machine *)user)->roots++;
  g[0] = y[1], g[1] = y[2];
  return 0;
}

/* Values that fit to the modes. Both diodes of a pair carry the same, by symmetry. */
static void bridge_settle(Machine *machine, double t, double *y, double *yp) {
  double ip = flow(machine->mode, 1), vp = drop(machine->mode, 1);
  double iq = flow(machine->second, 1), vq = drop(machine->second, 1), v = y[0];
  double p = (sine(t) - v - R_SOURCE * iq * v / vq) / (R_SOURCE * (ip + iq * vp / vq) + 2 * vp);
  double q = -(v + vp * p) / vq;
  y[1] = y[4] = p, y[2] = y[3] = q;
  y[5] = ip * p - iq * q, y[6] = v + vp * p, y[7] = -vp * p;
  yp[0] = (ip * p + iq * q - v / R_LOAD) / C_SMOOTH;
  for (int k = 1; k < 8; k++) yp[k] = 0;
  machine->direction[0] = machine->mode ? -1 : 1;
  machine->direction[1] = machine->second ? -1 : 1;
}

static void bridge_start(Machine *machine, double *y, double *yp) {
  machine->mode = 1, machine->second = 0;
  y[0] = 0;
  bridge_settle(machine, 0, y, yp);
}

static void bridge_differential(const Machine *machine, double *id) {
  (void)machine;
  for (int k = 0; k < 8; k++) id[k] = k == 0;
}

static void bridge_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  if (crossed[0]) machine->mode = !machine->mode;
  if (crossed[1]) machine->second = !machine->second;
  bridge_settle(machine, t, y, yp);
}

EventProblem bridge_problem(void) {
  EventProblem p = {"bridge", 8, 23, 2, 10, 0.01, bridge_residual, bridge_jacobian, bridge_root,
                    bridge_start, bridge_differential, bridge_event};
  return p;
}

/* Coil with resistance on a switched voltage: the current. 10 kHz, 10^5 events in 5 s. */
static const double PWM_L = 10e-3, PWM_R = 2, PWM_V = 24, PWM_PERIOD = 1e-4, PWM_DUTY = 0.4;

static int pwm_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  double i = *N_VGetArrayPointer(yy), di = *N_VGetArrayPointer(yyp);
  (void)t;
  machine->residuals++;
  *N_VGetArrayPointer(rr) = PWM_L * di + PWM_R * i - (machine->on ? PWM_V : 0);
  return 0;
}

static int pwm_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                        void *user, N_Vector a, N_Vector b, N_Vector c) {
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)a, (void)b, (void)c;
  ((Machine *)user)->jacobians++;
  column(&m), entry(&m, 0, PWM_L * cj + PWM_R);
  finish(&m);
  return 0;
}

/* Both times of a period are counted from its number: nothing accumulates. */
static void toggle(Machine *machine, double period, double duty) {
  machine->on = !machine->on;
  if (!machine->on) machine->count++;
  machine->next = (machine->count + (machine->on ? duty : 0)) * period;
}

static void pwm_start(Machine *machine, double *y, double *yp) {
  machine->on = 1, machine->count = 0, machine->next = PWM_DUTY * PWM_PERIOD;
  y[0] = 0, yp[0] = PWM_V / PWM_L;
}

static void pwm_differential(const Machine *machine, double *id) {
  (void)machine;
  id[0] = 1;
}

static void pwm_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)t, (void)crossed;
  toggle(machine, PWM_PERIOD, PWM_DUTY);
  yp[0] = ((machine->on ? PWM_V : 0) - PWM_R * y[0]) / PWM_L;
}

EventProblem pwm_problem(void) {
  EventProblem p = {"pwm", 1, 1, 0, 5, 1, pwm_residual, pwm_jacobian, 0,
                    pwm_start, pwm_differential, pwm_event};
  return p;
}

/* Buck converter: coil current, capacitor voltage, parameter of the free-wheeling diode. The
 * switch is a conductance from the source to the node between diode and coil. */
static const double B_V = 24, B_L = 100e-6, B_R = 0.05, B_C = 100e-6, B_LOAD = 5;
static const double B_PERIOD = 1 / 50e3, B_DUTY = 0.4;

static int buck_residual(double t, N_Vector yy, N_Vector yyp, N_Vector rr, void *user) {
  Machine *machine = user;
  const double *y = N_VGetArrayPointer(yy), *yp = N_VGetArrayPointer(yyp);
  double *r = N_VGetArrayPointer(rr), node = -drop(machine->mode, y[2]);
  double g = machine->on ? 1 / R_ON : G_OFF;
  (void)t;
  machine->residuals++;
  r[0] = B_L * yp[0] + B_R * y[0] + y[1] - node;
  r[1] = B_C * yp[1] + y[1] / B_LOAD - y[0];
  r[2] = (B_V - node) * g + flow(machine->mode, y[2]) - y[0];
  return 0;
}

static int buck_jacobian(double t, double cj, N_Vector yy, N_Vector yyp, N_Vector rr, SUNMatrix J,
                         void *user, N_Vector n1, N_Vector n2, N_Vector n3) {
  Machine *machine = user;
  double dv = drop(machine->mode, 1), g = machine->on ? 1 / R_ON : G_OFF;
  Columns m = columns_of(J);
  (void)t, (void)yy, (void)yyp, (void)rr, (void)n1, (void)n2, (void)n3;
  machine->jacobians++;
  column(&m), entry(&m, 0, B_L * cj + B_R), entry(&m, 1, -1), entry(&m, 2, -1);
  column(&m), entry(&m, 0, 1), entry(&m, 1, B_C * cj + 1 / B_LOAD);
  column(&m), entry(&m, 0, dv), entry(&m, 2, dv * g + flow(machine->mode, 1));
  finish(&m);
  return 0;
}

static int buck_root(double t, N_Vector yy, N_Vector yyp, double *g, void *user) {
  (void)t, (void)yyp;
  ((Machine *)user)->roots++;
  g[0] = N_VGetArrayPointer(yy)[2];
  return 0;
}

/* The state of the diode that fits to the coil current and the switch, and its parameter. */
static void buck_settle(Machine *machine, double *y, double *yp) {
  double g = machine->on ? 1 / R_ON : G_OFF;
  machine->mode = y[0] > B_V * g;
  machine->direction[0] = machine->mode ? -1 : 1;
  y[2] = (y[0] - B_V * g) / (machine->mode ? 1 + R_ON * g : g + G_OFF);
  yp[0] = (-drop(machine->mode, y[2]) - B_R * y[0] - y[1]) / B_L;
  yp[1] = (y[0] - y[1] / B_LOAD) / B_C;
  yp[2] = 0;
}

static void buck_start(Machine *machine, double *y, double *yp) {
  machine->on = 1, machine->count = 0, machine->next = B_DUTY * B_PERIOD;
  y[0] = y[1] = 0;
  buck_settle(machine, y, yp);
}

static void buck_differential(const Machine *machine, double *id) {
  (void)machine;
  id[0] = id[1] = 1, id[2] = 0;
}

static void buck_event(Machine *machine, double t, const int *crossed, double *y, double *yp) {
  (void)t;
  if (!crossed[0]) toggle(machine, B_PERIOD, B_DUTY);
  buck_settle(machine, y, yp);
}

EventProblem buck_problem(void) {
  EventProblem p = {"buck", 3, 7, 1, 1, 1, buck_residual, buck_jacobian, buck_root,
                    buck_start, buck_differential, buck_event};
  return p;
}
