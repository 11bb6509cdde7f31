/* Newmark's method in C, as an example of a command that the kit runs:
   cc -O2 -o newmark conformance/examples/newmark.c -lm && python -m conformance --command "./newmark {case} {out}"
   It reads a case, writes rows t,u1,v1,a1, and ends with 77 for what it does not do. One unknown. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static char text[1 << 20];
static double number(const char *key, double absent) {
  const char *at = strstr(text, key);
  return at ? strtod(at + strlen(key) + strspn(at + strlen(key), "\": ["), NULL) : absent;
}
static double S1, S2, S, g, k, A, frequency, phase;
static double force(double u) { return k * u + S1 * u * (1 + S2 * u * u) + S * tanh(u) + g * sin(u); }
static double tangent(double u) { return k + S1 * (1 + 3 * S2 * u * u) + S / pow(cosh(u), 2) + g * cos(u); }
static double load(double t) { return A * cos(frequency * t - phase); }
int main(int count, char **words) {
  FILE *in = count == 3 ? fopen(words[1], "r") : NULL, *out = count == 3 ? fopen(words[2], "w") : NULL;
  if (!in || !out) return fprintf(stderr, "usage: newmark CASE.json OUT.csv\n"), 2;
  text[fread(text, 1, sizeof text - 1, in)] = 0;
  if (!strstr(text, "\"newmark\"") && !strstr(text, "\"central_difference\"")) return 77;
  if (strstr(text, "\"elastoplastic\"") || strstr(text, "\"gap\"") || strstr(text, "\"ground\"")) return 77;
  if (strstr(text, "\"sizes\"")) return 77; /* steps that are not equal */
  if (strchr(strstr(text, "\"u0\""), ',') < strchr(strstr(text, "\"u0\""), ']')) return 77; /* several unknowns */
  double m = number("\"mass\"", 1), c = number("\"damping\"", 0), dt = number("\"dt\"", 0);
  double beta = number("\"beta\"", 0), gamma = number("\"gamma\"", 0.5), u = number("\"u0\"", 0), v = number("\"v0\"", 0);
  S1 = number("\"S1\"", 0), S2 = number("\"S2\"", 0), S = number("\"S\"", 0), g = number("\"g\"", 0);
  k = number("\"stiffness\"", 0), A = number("\"amplitude\"", 0);
  frequency = number("\"frequency\"", 0), phase = number("\"phase\"", 0);
  int steps = (int)number("\"steps\"", 0);
  double a = (load(0) - c * v - force(u)) / m;
  fprintf(out, "t,u1,v1,a1\n%.17g,%.17g,%.17g,%.17g\n", 0.0, u, v, a);
  for (int i = 1; i <= steps; i++) {
    double u_ahead = u + dt * v + dt * dt * (0.5 - beta) * a, v_ahead = v + dt * (1 - gamma) * a, t = i * dt;
    for (int j = 0; j < 50; j++) { /* Newton's iteration for the acceleration */
      double at = u_ahead + beta * dt * dt * a, residual = m * a + c * (v_ahead + gamma * dt * a) + force(at) - load(t);
      double change = residual / (m + gamma * dt * c + beta * dt * dt * tangent(at));
      a -= change;
      if (fabs(change) <= 1e-14 * fabs(a)) break;
    }
    u = u_ahead + beta * dt * dt * a, v = v_ahead + gamma * dt * a;
    fprintf(out, "%.17g,%.17g,%.17g,%.17g\n", t, u, v, a);
  }
  return fclose(out);
}
