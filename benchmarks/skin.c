/* The same skin substeps as handlab/simulation/soft_skin_kernel.py (leapfrog), in C: the peer of benchmarks/skin.py, which compiles it. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

void leapfrog(double *restrict position, double *restrict velocity, double *restrict force, const uint32_t *restrict first,
              const uint32_t *restrict second, const double *restrict stiffness, const double *restrict rest, double slack,
              const double *restrict anchor, const double *restrict hold, const double *restrict inverse_mass, double dt, int steps,
              double damping, int n, int edges)
{
    const double lost = 0.5 * damping * dt;
    const double kept = (1.0 - lost) / (1.0 + lost), gained = dt / (1.0 + lost), dragged = 2.0 * lost / (1.0 + lost) / (dt * steps);
    double *px = position, *py = position + n, *pz = position + 2 * n;
    double *vx = velocity, *vy = velocity + n, *vz = velocity + 2 * n;
    double *fx = force, *fy = force + n, *fz = force + 2 * n;
    double *restrict wx = malloc(sizeof(double) * edges), *restrict wy = malloc(sizeof(double) * edges);
    double *restrict wz = malloc(sizeof(double) * edges), *restrict pull = malloc(sizeof(double) * edges);
    for (int step = 0; step < steps; step++) {
        const double share = (double)step / steps;
        for (int i = 0; i < n; i++) {
            const double x = px[i] - anchor[i] - share * anchor[3 * n + i];
            const double y = py[i] - anchor[n + i] - share * anchor[4 * n + i];
            const double z = pz[i] - anchor[2 * n + i] - share * anchor[5 * n + i];
            const double hx = anchor[6 * n + i], hy = anchor[7 * n + i], hz = anchor[8 * n + i], l = anchor[9 * n + i];
            const double ax = x + hx, ay = y + hy, az = z + hz, bx = x - hx, by = y - hy, bz = z - hz;
            const double a = l / sqrt(ax * ax + ay * ay + az * az) - 1.0, b = l / sqrt(bx * bx + by * by + bz * bz) - 1.0;
            fx[i] = hold[i] * (a * ax + b * bx);
            fy[i] = hold[i] * (a * ay + b * by);
            fz[i] = hold[i] * (a * az + b * bz);
        }
        for (int e = 0; e < edges; e++) {
            const uint32_t i = first[e], j = second[e];
            wx[e] = px[j] - px[i];
            wy[e] = py[j] - py[i];
            wz[e] = pz[j] - pz[i];
        }
        for (int e = 0; e < edges; e++) {
            const double strain = 1.0 - rest[e] / sqrt(wx[e] * wx[e] + wy[e] * wy[e] + wz[e] * wz[e]);
            pull[e] = stiffness[e] * ((strain > 0.0 ? strain : 0.0) + slack * (strain < 0.0 ? strain : 0.0));
        }
        for (int e = 0; e < edges; e++) {
            const uint32_t i = first[e], j = second[e];
            const double x = pull[e] * wx[e], y = pull[e] * wy[e], z = pull[e] * wz[e];
            fx[i] += x;
            fy[i] += y;
            fz[i] += z;
            fx[j] -= x;
            fy[j] -= y;
            fz[j] -= z;
        }
        for (int i = 0; i < n; i++) {
            const double push = gained * inverse_mass[i];
            vx[i] = kept * vx[i] + push * fx[i] + dragged * anchor[3 * n + i];
            vy[i] = kept * vy[i] + push * fy[i] + dragged * anchor[4 * n + i];
            vz[i] = kept * vz[i] + push * fz[i] + dragged * anchor[5 * n + i];
            px[i] += dt * vx[i];
            py[i] += dt * vy[i];
            pz[i] += dt * vz[i];
        }
    }
    free(wx);
    free(wy);
    free(wz);
    free(pull);
}
