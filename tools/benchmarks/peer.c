/* The formulas of the study's schemes in C. The benchmark compares this code, compiled by a C compiler, with the code of
 * the study, compiled by XLA. The energy is observed, Newton's convergence is tested and a failure is reported, as in
 * study/marching/march.py.
 *
 * The benchmark compiles it twice: with -O3 -march=native for a single run, and also with -ffast-math -fopenmp-simd for
 * the ensemble with two fixed iterations. SPRING is 0 for the hardening spring and 1 for the softening one. */
#include <math.h>

#define TOLERANCE 1e-12
#define NEAR 1e-8
#define FORETOLD 1e-17
#define MAX_ITERATIONS 50

#if SPRING == 0
static inline double force(double u) { return 100.0 * u * (1 + 10.0 * u * u); }
static inline double tangent(double u) { return 100.0 * (1 + 30.0 * u * u); }
static inline double potential(double u) { return 50.0 * u * u * (1 + 5.0 * u * u); }
#else
static inline double force(double u) { return 100.0 * tanh(u); }
static inline double tangent(double u) { double t = tanh(u); return 100.0 * (1 - t * t); }
static inline double potential(double u) {
  double t = fabs(tanh(u)), s = t / (2 + t), z = s * s, even = 0, odd = 0;
  for (int n = 29; n > 0; n -= 4) {
    even = even * (z * z) + 1.0 / n;
    odd = odd * (z * z) + 1.0 / (n + 2);
  }
  return 100.0 * (fabs(u) - 2 * s * (even + z * odd));
}
#endif

/* Solve a + w p(u + c_u a) = r for a. */
static inline int balance(double r, double u, double c_u, double w, double *a) {
  int iterations = 0;
  double before, moved = 0, size;
  int unfinished;
  do {
    double at = u + c_u * *a;
    double correction = (*a + w * force(at) - r) / (1 + w * c_u * tangent(at));
    *a -= correction;
    before = moved;
    moved = fabs(c_u * correction);
    size = fabs(u) + fabs(c_u * *a);
    int foretold = iterations == 1 && moved <= NEAR * size && moved * moved * moved <= FORETOLD * size * before * before;
    unfinished = moved > TOLERANCE * size && !foretold;
    iterations++;
  } while (unfinished && iterations < MAX_ITERATIONS);
  return !unfinished;
}

typedef struct { double u, v, a, u_1, u_2; } State;

static inline int newmark(State *s, double dt, double beta, double gamma) {
  double du = dt * s->v + dt * dt * (0.5 - beta) * s->a, dv = dt * (1 - gamma) * s->a, a = s->a;
  int converged = balance(0, s->u + du, beta * dt * dt, 1, &a);
  *s = (State){s->u + (du + beta * dt * dt * a), s->v + (dv + gamma * dt * a), a, 0, 0};
  return converged;
}

static inline int central_difference(State *s, double dt) {
  double u = s->u + (dt * s->v + dt * dt * 0.5 * s->a), a = -force(u);
  *s = (State){u, s->v + (dt * 0.5 * s->a + 0.5 * dt * a), a, 0, 0};
  return 1;
}

static inline int wilson(State *s, double dt, double theta) {
  const double beta = 1.0 / 6, tau = theta * dt;
  double u = s->u + tau * s->v + tau * tau * (0.5 - beta) * s->a, a = s->a;
  int converged = balance(0, u, beta * tau * tau, 1, &a);
  a = (1 - 1 / theta) * s->a + a / theta;
  *s = (State){s->u + (dt * s->v + dt * dt * ((0.5 - beta) * s->a + beta * a)), s->v + dt * 0.5 * (s->a + a), a, 0, 0};
  return converged;
}

static inline int hht(State *s, double dt, double alpha, double beta, double gamma) {
  double du = dt * s->v + dt * dt * (0.5 - beta) * s->a, dv = dt * (1 - gamma) * s->a, a = s->a;
  int converged = balance(alpha * force(s->u), s->u + du, beta * dt * dt, 1 + alpha, &a);
  *s = (State){s->u + (du + beta * dt * dt * a), s->v + (dv + gamma * dt * a), a, 0, 0};
  return converged;
}

static inline int houbolt(State *s, double dt) {
  double u = (5 * s->u - 4 * s->u_1 + s->u_2) / 2, a = s->a;
  double v = (11 * u - 18 * s->u + 9 * s->u_1 - 2 * s->u_2) / (6 * dt);
  int converged = balance(0, u, dt * dt / 2, 1, &a);
  *s = (State){u + dt * dt / 2 * a, v + 11 * dt / 12 * a, a, s->u, s->u_1};
  return converged;
}

static inline int rk4(State *s, double dt) {
  double u1 = dt * s->v, v1 = -dt * force(s->u);
  double u2 = dt * (s->v + v1 / 2), v2 = -dt * force(s->u + u1 / 2);
  double u3 = dt * (s->v + v2 / 2), v3 = -dt * force(s->u + u2 / 2);
  double u4 = dt * (s->v + v3), v4 = -dt * force(s->u + u3);
  *s = (State){s->u + ((u1 + u4) / 6 + (u2 + u3) / 3), s->v + ((v1 + v4) / 6 + (v2 + v3) / 3), 0, 0, 0};
  return 1;
}

/* Largest energy error relative to the initial energy, or minus the step of the failure. */
#define RUN(NAME, STEP)                                                                          \
  double NAME(double u0, double dt, long steps) {                                                \
    State s = {u0, 0, -force(u0), 0, 0};                                                         \
    /* Houbolt's fictitious points, which make the first step one of linear acceleration */      \
    State first = s;                                                                             \
    newmark(&first, dt, 1.0 / 6, 0.5);                                                           \
    s.u_1 = dt * dt * s.a + 2 * u0 - first.u;                                                    \
    s.u_2 = 6 * dt * s.v + 6 * dt * dt * s.a + 9 * u0 - 8 * first.u;                             \
    double energy = potential(u0), largest = 0;                                                  \
    for (long step = 1; step <= steps; step++) {                                                 \
      int converged = STEP;                                                                      \
      double error = fabs(0.5 * s.v * s.v + potential(s.u) - energy);                            \
      largest = error > largest ? error : largest;                                               \
      if (!isfinite(s.u) || !isfinite(s.v) || !converged) return -step;                          \
    }                                                                                            \
    return largest / fabs(energy);                                                               \
  }

RUN(run_average_acceleration, newmark(&s, dt, 0.25, 0.5))
RUN(run_central_difference, central_difference(&s, dt))
RUN(run_newmark_dissipative, newmark(&s, dt, 0.3025, 0.6))
RUN(run_wilson_theta, wilson(&s, dt, 1.4))
RUN(run_houbolt, houbolt(&s, dt))
RUN(run_hht_alpha_1996, hht(&s, dt, -0.1, 0.3025, 0.6))
RUN(run_rk4, rk4(&s, dt))

/* Average acceleration on an ensemble, tile by tile, with two iterations and no tests of convergence or failure. */
#define TILE 128
void ensemble(long lanes, double dt, long steps, double *u, double *v, double *a, double *largest) {
  const double c_u = 0.25 * dt * dt;
  for (long first = 0; first < lanes; first += TILE) {
    double energy[TILE];
    for (int i = 0; i < TILE; i++) energy[i] = potential(u[first + i]);
    for (long step = 0; step < steps; step++)
#pragma omp simd
      for (int i = 0; i < TILE; i++) {
        double *ui = u + first + i, *vi = v + first + i, *ai = a + first + i, acceleration = *ai;
        double du = dt * *vi + c_u * *ai, dv = 0.5 * dt * *ai;
        for (int iteration = 0; iteration < 2; iteration++) {
          double at = *ui + du + c_u * acceleration;
          acceleration -= (acceleration + force(at)) / (1 + c_u * tangent(at));
        }
        *ui += du + c_u * acceleration;
        *vi += dv + 0.5 * dt * acceleration;
        *ai = acceleration;
        double error = fabs(0.5 * *vi * *vi + potential(*ui) - energy[i]);
        largest[first + i] = error > largest[first + i] ? error : largest[first + i];
      }
  }
}
