/* A hardening spring, u'' + u + u^3 / 2 = 0 from u = 1 at rest, by two schemes: an example of a program in C.

   cc -O2 -o oscillator examples/oscillator.c -lm
   study assess --command "./oscillator --scheme {scheme} --dt {dt} --output {output}" \
     --schemes average_acceleration central_difference --duration 10 --output oscillator */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double force(double u) { return u + u * u * u / 2; }
static double slope(double u) { return 1 + 1.5 * u * u; }

/* The acceleration at the end of a step of average acceleration, by Newton's iteration. */
static double solve(double u, double v, double a, double dt)
{
    double weight = dt * dt / 4, predicted = u + dt * v + weight * a, new = a;
    for (int i = 0; i < 50; i++) {
        double reached = predicted + weight * new;
        double correction = (new + force(reached)) / (1 + weight * slope(reached));
        new -= correction;
        if (fabs(correction) < 1e-14)
            return new;
    }
    fprintf(stderr, "Newton's iteration does not end at a step of %g s\n", dt);
    exit(1);
}

int main(int count, char **words)
{
    const char *scheme = "", *output = "";
    double dt = 0, duration = 10;
    for (int i = 1; i + 1 < count; i += 2) {
        if (!strcmp(words[i], "--scheme"))
            scheme = words[i + 1];
        else if (!strcmp(words[i], "--output"))
            output = words[i + 1];
        else if (!strcmp(words[i], "--dt"))
            dt = atof(words[i + 1]);
    }
    int explicit = !strcmp(scheme, "central_difference");
    FILE *file = fopen(output, "w");
    if (!file || dt <= 0 || (!explicit && strcmp(scheme, "average_acceleration"))) {
        fprintf(stderr, "usage: oscillator --scheme NAME --dt SECONDS --output FILE\n");
        return 2;
    }
    double u = 1, v = 0, a = -force(u);
    fprintf(file, "t,displacement,velocity\n0,%.17g,%.17g\n", u, v);
    for (long i = 1; i <= ceil(duration / dt - 1e-9); i++) {
        double before = a;
        a = explicit ? -force(u + dt * v + dt * dt / 2 * a) : solve(u, v, a, dt);
        u += explicit ? dt * v + dt * dt / 2 * before : dt * v + dt * dt / 4 * (before + a);
        v += dt / 2 * (before + a);
        fprintf(file, "%.17g,%.17g,%.17g\n", i * dt, u, v);
    }
    return fclose(file) != 0;
}
