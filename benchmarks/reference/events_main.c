/* Integrates a problem with events with IDA and KLU, as a program written by hand for it would:
 * root functions, a stop time at events known beforehand, IDAReInit after each.
 *
 *   events PROBLEM SIZE RELATIONS REPEATS RELATIVE ABSOLUTE STOP END_FILE
 *
 * STOP 0 takes the problem's own. Prints one line of JSON per repeat; END_FILE ("-" for none)
 * receives the number of events and the unknowns at the end as doubles.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "events.h"

static double clock_of(clockid_t which) {
  struct timespec t;
  clock_gettime(which, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int check(int flag, const char *what) {
  if (flag < 0) {
    fprintf(stderr, "%s returned %d\n", what, flag);
    exit(1);
  }
  return flag;
}

static EventProblem chosen(const char *name, const Machine *machine) {
  if (!strcmp(name, "ball")) return ball_problem();
  if (!strcmp(name, "stick_slip")) return stick_slip_problem();
  if (!strcmp(name, "half_wave")) return half_wave_problem();
  if (!strcmp(name, "bridge")) return bridge_problem();
  if (!strcmp(name, "pwm")) return pwm_problem();
  if (!strcmp(name, "buck")) return buck_problem();
  if (!strcmp(name, "array")) return array_problem(machine->size, machine->relations);
  fprintf(stderr, "there is no problem %s\n", name);
  exit(2);
}

int main(int argc, char **argv) {
  if (argc != 9) {
    fprintf(stderr, "events PROBLEM SIZE RELATIONS REPEATS RELATIVE ABSOLUTE STOP END_FILE\n");
    return 2;
  }
  int repeats = atoi(argv[4]);
  for (int run = 0; run < repeats; run++) {
    Machine machine = {.size = atol(argv[2]), .relations = atoi(argv[3]), .next = INFINITY};
    EventProblem p = chosen(argv[1], &machine);
    double stop = atof(argv[7]) > 0 ? atof(argv[7]) : p.stop_time;
    double t = 0, events = 0;
    long steps, all = 0;
    int *crossed = calloc((size_t)p.roots + 1, sizeof *crossed);
    int *none = calloc((size_t)p.roots + 1, sizeof *none);
    SUNContext context;
    check(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
    N_Vector y = N_VNew_Serial(p.unknowns, context), yp = N_VNew_Serial(p.unknowns, context);
    N_Vector id = N_VNew_Serial(p.unknowns, context);
    double *values = N_VGetArrayPointer(y), *rates = N_VGetArrayPointer(yp);
    p.start(&machine, values, rates);
    p.differential(&machine, N_VGetArrayPointer(id));
    void *ida = IDACreate(context);
    check(IDAInit(ida, p.residual, 0, y, yp), "IDAInit");
    check(IDASStolerances(ida, atof(argv[5]), atof(argv[6])), "IDASStolerances");
    check(IDASetUserData(ida, &machine), "IDASetUserData");
    check(IDASetMaxNumSteps(ida, 100000000), "IDASetMaxNumSteps");
    check(IDASetId(ida, id), "IDASetId");
    check(IDASetSuppressAlg(ida, 1), "IDASetSuppressAlg");
    SUNMatrix J = SUNSparseMatrix(p.unknowns, p.unknowns, p.nonzeros, CSC_MAT, context);
    SUNLinearSolver solver = SUNLinSol_KLU(y, J, context);
    check(SUNLinSol_KLUSetOrdering(solver, 0), "SUNLinSol_KLUSetOrdering");
    check(IDASetLinearSolver(ida, solver, J), "IDASetLinearSolver");
    check(IDASetJacFn(ida, p.jacobian), "IDASetJacFn");
    if (p.roots > 0) {
      check(IDARootInit(ida, p.roots, p.root), "IDARootInit");
      check(IDASetNoInactiveRootWarn(ida), "IDASetNoInactiveRootWarn");
      if (p.roots <= 2)
        check(IDASetRootDirection(ida, machine.direction), "IDASetRootDirection");
    }
    double began = clock_of(CLOCK_MONOTONIC), cpu = clock_of(CLOCK_THREAD_CPUTIME_ID);
    while (t < stop) {
      double known = machine.next < stop ? machine.next : stop;
      double target = t + p.horizon < known ? t + p.horizon : known;
      check(IDASetStopTime(ida, known), "IDASetStopTime");
      int flag = check(IDASolve(ida, target, &t, y, yp, IDA_NORMAL), "IDASolve");
      if (flag != IDA_ROOT_RETURN && target < known) continue;
      if (flag != IDA_ROOT_RETURN && known >= stop) break;
      if (flag == IDA_ROOT_RETURN) check(IDAGetRootInfo(ida, crossed), "IDAGetRootInfo");
      IDAGetNumSteps(ida, &steps);
      all += steps;
      events++;
      p.event(&machine, t, flag == IDA_ROOT_RETURN ? crossed : none, values, rates);
      check(IDAReInit(ida, t, y, yp), "IDAReInit");
      if (p.roots > 0 && p.roots <= 2)
        check(IDASetRootDirection(ida, machine.direction), "IDASetRootDirection");
    }
    cpu = clock_of(CLOCK_THREAD_CPUTIME_ID) - cpu;
    double done = clock_of(CLOCK_MONOTONIC);
    IDAGetNumSteps(ida, &steps);
    printf("{\"cpu\": %.9f, \"wall\": %.9f, \"unknowns\": %ld, \"steps\": %ld, \"events\": %.0f, "
           "\"residuals\": %ld, \"jacobians\": %ld, \"roots\": %ld}\n",
           cpu, done - began, (long)p.unknowns, all + steps, events, machine.residuals,
           machine.jacobians, machine.roots);
    fflush(stdout);
    if (run == repeats - 1 && strcmp(argv[8], "-")) {
      FILE *file = fopen(argv[8], "wb");
      if (!file) return 3;
      fwrite(&events, sizeof events, 1, file);
      fwrite(values, sizeof(double), (size_t)p.unknowns, file);
      fclose(file);
    }
    IDAFree(&ida);
    SUNLinSolFree(solver);
    SUNMatDestroy(J);
    N_VDestroy(y), N_VDestroy(yp), N_VDestroy(id);
    SUNContext_Free(&context);
    free(crossed), free(none);
  }
  return 0;
}
