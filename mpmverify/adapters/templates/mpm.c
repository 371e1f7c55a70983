/* Total Lagrangian material point method in two dimensions with quadratic B-splines, FLIP and MUSL, for a neo-Hookean body that
 * touches no face of its box. It reads problem.txt and the tables beside it, and writes result.csv. Build: cc -O2 -o mpm mpm.c -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef double vec[2];

static void refuse(const char *why) {
    puts(why);
    exit(77); /* this status says that the program does not take the problem; its last line says why */
}

static FILE *opened(const char *path, const char *mode) {
    FILE *file = fopen(path, mode);
    if (!file) { perror(path); exit(1); }
    return file;
}

/* The k-th word after a name in problem.txt. */
static const char *word(const char *name, int k) {
    static char line[1 << 20];
    FILE *file = opened("problem.txt", "r");
    while (fgets(line, sizeof line, file)) {
        char *part = strtok(line, " \n");
        if (!part || strcmp(part, name)) continue;
        while (k-- >= 0 && part) part = strtok(NULL, " \n");
        if (!part) break;
        fclose(file);
        return part;
    }
    fprintf(stderr, "problem.txt lacks %s\n", name);
    exit(1);
}

static double number(const char *name, int k) { return atof(word(name, k)); }

/* A table of numbers, after its line of column names. */
static double *table(const char *path, long rows, long columns) {
    double *values = malloc(sizeof(double) * rows * columns);
    FILE *file = opened(path, "r");
    for (int c = 0; c != '\n' && c != EOF;) c = fgetc(file);
    for (long i = 0; i < rows * columns; i++)
        if (fscanf(file, "%lf", &values[i]) != 1) { fprintf(stderr, "%s is too short\n", path); exit(1); }
    fclose(file);
    return values;
}

/* The quadratic B-spline at s cells from its node, and its slope. */
static void spline(double s, double *N, double *dN) {
    double a = fabs(s);
    *N = a < 0.5 ? 0.75 - a * a : 0.5 * (1.5 - a) * (1.5 - a);
    *dN = a < 0.5 ? -2 * s : (s > 0 ? a - 1.5 : 1.5 - a);
}

int main(void) {
    if (number("dimension", 0) != 2 || strcmp(word("law", 0), "NeoHookean")) refuse("it takes neo-Hookean bodies in two dimensions");
    double h = number("h", 0), dt = number("dt", 0), density = number("density", 0);
    double lambda = number("lame_lambda", 0), mu = number("shear_modulus", 0);
    double lower[2] = {number("lower", 0), number("lower", 1)};
    int nx = (int)number("cells", 0), ny = (int)number("cells", 1), steps = (int)number("steps", 0);
    long P = (long)number("points", 0), nodes = (long)(nx + 2) * (ny + 2);
    int K = (int)number("body_force_modes", 0), shown = 0;

    /* reference position 2, weight 1, displacement 2, velocity 2, stress 3, displacement gradient 4 */
    double *points = table("points.txt", P, 14);
    double *amplitude = K ? table("body_force_amplitudes.txt", 2 * steps + 1, K) : NULL;
    double *mode = K ? table("body_force_modes.txt", P, 2 * K) : NULL;

    long (*at)[9] = malloc(sizeof(long[9]) * P);
    double (*N)[9] = malloc(sizeof(double[9]) * P), (*G)[9][2] = malloc(sizeof(double[9][2]) * P), (*F)[2][2] = malloc(sizeof(double[2][2]) * P);
    vec *u = malloc(sizeof(vec) * P), *v = malloc(sizeof(vec) * P), *a = malloc(sizeof(vec) * P);
    double *M = calloc(nodes, sizeof(double));
    vec *p_I = malloc(sizeof(vec) * nodes), *f_I = malloc(sizeof(vec) * nodes);

    for (long p = 0; p < P; p++) {
        double *row = points + 14 * p, x = (row[0] - lower[0]) / h + 0.5, y = (row[1] - lower[1]) / h + 0.5; /* nodes in the middle of cells */
        long i = lrint(x) - 1, j = lrint(y) - 1;
        if (i < 1 || j < 1 || i + 2 > nx || j + 2 > ny) refuse("it takes bodies that touch no face of the box");
        for (int k = 0; k < 9; k++) {
            double Nx, Ny, dx, dy;
            spline(x - (i + k / 3), &Nx, &dx);
            spline(y - (j + k % 3), &Ny, &dy);
            at[p][k] = (i + k / 3) * (ny + 2) + j + k % 3;
            N[p][k] = Nx * Ny;
            G[p][k][0] = dx * Ny / h;
            G[p][k][1] = Nx * dy / h;
            M[at[p][k]] += density * row[2] * N[p][k];
        }
        for (int c = 0; c < 2; c++) {
            if (row[3 + c] != 0) refuse("it takes bodies that begin undeformed");
            u[p][c] = 0;
            v[p][c] = row[5 + c];
            for (int d = 0; d < 2; d++) F[p][c][d] = c == d;
        }
    }

    FILE *out = opened("result.csv", "w");
    fprintf(out, "time,displacement_x,displacement_y,velocity_x,velocity_y\n");
    for (int n = 0; n <= steps; n++) {
        double kick = n ? dt / 2 : 0, leap = n ? dt : dt / 2; /* velocities are half a step ahead */
        memset(p_I, 0, sizeof(vec) * nodes);
        memset(f_I, 0, sizeof(vec) * nodes);
        for (long p = 0; p < P; p++) { /* momentum and force of the nodes */
            double J = F[p][0][0] * F[p][1][1] - F[p][0][1] * F[p][1][0], V = points[14 * p + 2], b[2] = {0, 0}, S[2][2];
            double inverse[2][2] = {{F[p][1][1] / J, -F[p][1][0] / J}, {-F[p][0][1] / J, F[p][0][0] / J}}; /* transposed */
            for (int c = 0; c < 2; c++) {
                for (int d = 0; d < 2; d++) S[c][d] = lambda * log(J) * inverse[c][d] + mu * (F[p][c][d] - inverse[c][d]);
                for (int k = 0; k < K; k++) b[c] += amplitude[2L * n * K + k] * mode[2 * (p * K + k) + c];
            }
            for (int k = 0; k < 9; k++)
                for (int c = 0; c < 2; c++) {
                    p_I[at[p][k]][c] += density * V * N[p][k] * v[p][c];
                    f_I[at[p][k]][c] += density * V * N[p][k] * b[c] - V * (S[c][0] * G[p][k][0] + S[c][1] * G[p][k][1]);
                }
        }
        for (long p = 0; p < P; p++)
            for (int c = 0; c < 2; c++) {
                a[p][c] = 0;
                for (int k = 0; k < 9; k++) a[p][c] += N[p][k] * f_I[at[p][k]][c] / M[at[p][k]];
            }
        if (n == (int)number("output_steps", shown)) {
            shown += n < steps;
            for (long p = 0; p < P; p++)
                fprintf(out, "%.17g,%.17g,%.17g,%.17g,%.17g\n", n * dt, u[p][0], u[p][1], v[p][0] + kick * a[p][0], v[p][1] + kick * a[p][1]);
        }
        for (long p = 0; p < P; p++) /* positions by the velocity of the nodes, velocities by its increment */
            for (int c = 0; c < 2; c++) {
                for (int k = 0; k < 9; k++) u[p][c] += dt * N[p][k] * (p_I[at[p][k]][c] + leap * f_I[at[p][k]][c]) / M[at[p][k]];
                v[p][c] += leap * a[p][c];
            }
        memset(p_I, 0, sizeof(vec) * nodes);
        for (long p = 0; p < P; p++) /* MUSL: momentum of the nodes once more */
            for (int k = 0; k < 9; k++)
                for (int c = 0; c < 2; c++) p_I[at[p][k]][c] += density * points[14 * p + 2] * N[p][k] * v[p][c];
        for (long p = 0; p < P; p++)
            for (int k = 0; k < 9; k++)
                for (int c = 0; c < 2; c++)
                    for (int d = 0; d < 2; d++) F[p][c][d] += dt * p_I[at[p][k]][c] / M[at[p][k]] * G[p][k][d];
    }
    return fclose(out);
}
