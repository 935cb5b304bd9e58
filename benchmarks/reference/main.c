/* Integrates one problem with IDA and KLU, as a program written by hand for it would.
 *
 *   reference PROBLEM SIZE REPEATS POINTS RELATIVE ABSOLUTE SUPPRESS END_FILE
 *
 * SUPPRESS 1 leaves algebraic unknowns out of the error test. Prints one line of JSON per repeat:
 * processor seconds of the integration alone, wall seconds, and counts. END_FILE ("-" for none)
 * receives the unknowns at the end as doubles.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "problem.h"

static double clock_of(clockid_t which) {
  struct timespec t;
  clock_gettime(which, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void check(int flag, const char *what) {
  if (flag < 0) {
    fprintf(stderr, "%s returned %d\n", what, flag);
    exit(1);
  }
}

int main(int argc, char **argv) {
  if (argc != 9) {
    fprintf(stderr, "reference PROBLEM SIZE REPEATS POINTS RELATIVE ABSOLUTE SUPPRESS END_FILE\n");
    return 2;
  }
  Work work = {(sunindextype)atol(argv[2]), 0, 0};
  int repeats = atoi(argv[3]), points = atoi(argv[4]), suppress = atoi(argv[7]);
  double relative = atof(argv[5]), absolute = atof(argv[6]);
  Problem p = !strcmp(argv[1], "ladder")      ? ladder_problem(work.size)
              : !strcmp(argv[1], "rectifier") ? rectifier_problem()
                                              : pendulum_problem();
  for (int run = 0; run < repeats; run++) {
    double began = clock_of(CLOCK_MONOTONIC), t = 0;
    long steps, failures;
    SUNContext context;
    work.residuals = work.jacobians = 0;
    check(SUNContext_Create(SUN_COMM_NULL, &context), "SUNContext_Create");
    N_Vector y = N_VNew_Serial(p.unknowns, context), yp = N_VNew_Serial(p.unknowns, context);
    N_Vector id = N_VNew_Serial(p.unknowns, context);
    p.start(&work, N_VGetArrayPointer(y), N_VGetArrayPointer(yp));
    p.differential(&work, N_VGetArrayPointer(id));
    void *ida = IDACreate(context);
    check(IDAInit(ida, p.residual, 0, y, yp), "IDAInit");
    check(IDASStolerances(ida, relative, absolute), "IDASStolerances");
    check(IDASetUserData(ida, &work), "IDASetUserData");
    check(IDASetMaxNumSteps(ida, 100000000), "IDASetMaxNumSteps");
    check(IDASetId(ida, id), "IDASetId");
    check(IDASetSuppressAlg(ida, suppress), "IDASetSuppressAlg");
    SUNMatrix J = SUNSparseMatrix(p.unknowns, p.unknowns, p.nonzeros, CSC_MAT, context);
    SUNLinearSolver solver = SUNLinSol_KLU(y, J, context);
    check(SUNLinSol_KLUSetOrdering(solver, 0), "SUNLinSol_KLUSetOrdering");
    check(IDASetLinearSolver(ida, solver, J), "IDASetLinearSolver");
    check(IDASetJacFn(ida, p.jacobian), "IDASetJacFn");
    if (p.first_step > 0) {
      check(IDASetInitStep(ida, p.first_step), "IDASetInitStep");
      check(IDASetMaxErrTestFails(ida, 20), "IDASetMaxErrTestFails");
    }
    if (!p.consistent) {
      check(IDACalcIC(ida, IDA_YA_YDP_INIT, p.stop_time * 1e-5), "IDACalcIC");
      check(IDAGetConsistentIC(ida, y, yp), "IDAGetConsistentIC");
    }
    double ready = clock_of(CLOCK_MONOTONIC), cpu = clock_of(CLOCK_THREAD_CPUTIME_ID);
    for (int k = 1; k <= points; k++)
      check(IDASolve(ida, p.stop_time * k / points, &t, y, yp, IDA_NORMAL), "IDASolve");
    cpu = clock_of(CLOCK_THREAD_CPUTIME_ID) - cpu;
    double done = clock_of(CLOCK_MONOTONIC);
    IDAGetNumSteps(ida, &steps);
    IDAGetNumErrTestFails(ida, &failures);
    printf("{\"cpu\": %.9f, \"wall\": %.9f, \"setup\": %.9f, \"unknowns\": %ld, \"steps\": %ld, "
           "\"residuals\": %ld, \"jacobians\": %ld, \"failures\": %ld}\n",
           cpu, done - ready, ready - began, (long)p.unknowns, steps, work.residuals,
           work.jacobians, failures);
    fflush(stdout);
    if (run == repeats - 1 && strcmp(argv[8], "-")) {
      FILE *file = fopen(argv[8], "wb");
      if (!file) return 3;
      fwrite(N_VGetArrayPointer(y), sizeof(double), (size_t)p.unknowns, file);
      fclose(file);
    }
    IDAFree(&ida);
    SUNLinSolFree(solver);
    SUNMatDestroy(J);
    N_VDestroy(y), N_VDestroy(yp), N_VDestroy(id);
    SUNContext_Free(&context);
  }
  return 0;
}
