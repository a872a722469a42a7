/* The inelastic Lorentz gas among hard disks, by itself: no line of this is shared with the package.
 *
 *     cc -O2 -o lorentz lorentz.c -lm
 *     ./lorentz RESTITUTION DENSITY DISKS MEDIA TRACERS SEED TIME [TIME ...]
 *
 * Disks of diameter 1 are placed one after the other at random in a periodic square; one that would
 * overlap an earlier one is drawn again. A tracer of the same size starts at a random free place with
 * a Gaussian velocity of unit variance in each component, flies straight, and at contact loses normal
 * velocity: v' = v - (1 + e)(v.s)s. Every row of the output is: medium tracer time x y vx vy, with x
 * and y from the start. Lengths are in diameters.
 *
 * A flight is followed from cell to cell of a grid of side 1 or a little more: a disk touches a tracer
 * only if its centre lies within 1, so the 3 x 3 cells about the tracer's are looked at.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t state;

static double uniform(void) { /* xorshift64*, in (0, 1) */
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return ((state * 2685821657736338717ULL >> 11) + 0.5) / 9007199254740992.0;
}

static double gaussian(void) {
    return sqrt(-2.0 * log(uniform())) * cos(2.0 * M_PI * uniform());
}

static double side, cell;
static int cells, *head, *next;
static double *px, *py;

static int cell_of(double x, double y) {
    int i = (int)(x / cell) % cells, j = (int)(y / cell) % cells;
    return i * cells + j;
}

static double nearest(double d) { return d - side * floor(d / side + 0.5); }

static int is_free(double x, double y) {
    int i = (int)(x / cell), j = (int)(y / cell);
    for (int a = -1; a <= 1; a++)
        for (int b = -1; b <= 1; b++) {
            int k = ((i + a + cells) % cells) * cells + (j + b + cells) % cells;
            for (int d = head[k]; d >= 0; d = next[d]) {
                double dx = nearest(x - px[d]), dy = nearest(y - py[d]);
                if (dx * dx + dy * dy < 1.0) return 0;
            }
        }
    return 1;
}

/* The first contact on a straight flight of at most `longest`; -1 for none. */
static int first_contact(double x, double y, double ux, double uy, int last, double longest,
                         double *distance) {
    double gone = 0.0;
    while (gone < longest) {
        double cx = x + ux * gone, cy = y + uy * gone;
        cx -= side * floor(cx / side);
        cy -= side * floor(cy / side);
        int i = (int)(cx / cell), j = (int)(cy / cell), found = -1;
        double step = cell * 0.5, best = 1e300; /* the 3 x 3 cells reach further than this and 1 */
        for (int a = -1; a <= 1; a++)
            for (int b = -1; b <= 1; b++) {
                int k = ((i + a + cells) % cells) * cells + (j + b + cells) % cells;
                for (int d = head[k]; d >= 0; d = next[d]) {
                    if (d == last) continue;
                    double dx = nearest(px[d] - cx), dy = nearest(py[d] - cy);
                    double along = dx * ux + dy * uy, across2 = dx * dx + dy * dy - along * along;
                    if (across2 >= 1.0) continue;
                    double at = along - sqrt(1.0 - across2);
                    if (at > -1e-9 && along > 0.0 && at < best) {
                        best = at;
                        found = d;
                    }
                }
            }
        if (found >= 0 && best <= step && gone + best <= longest) {
            *distance = gone + (best > 0.0 ? best : 0.0);
            return found;
        }
        gone += step;
    }
    *distance = longest;
    return -1;
}

int main(int argc, char **argv) {
    if (argc < 8) return 2;
    double e = atof(argv[1]), density = atof(argv[2]);
    int disks = atoi(argv[3]), media = atoi(argv[4]), tracers = atoi(argv[5]), times = argc - 7;
    state = 88172645463325252ULL ^ (uint64_t)atoll(argv[6]) * 1442695040888963407ULL;
    side = sqrt(disks / density);
    cells = (int)(side / 2.0); /* cells of side 2 or a little more */
    cell = side / cells;
    head = malloc(sizeof(int) * cells * cells);
    next = malloc(sizeof(int) * disks);
    px = malloc(sizeof(double) * disks);
    py = malloc(sizeof(double) * disks);
    for (int medium = 0; medium < media; medium++) {
        for (int k = 0; k < cells * cells; k++) head[k] = -1;
        for (int d = 0; d < disks;) {
            double x = side * uniform(), y = side * uniform();
            if (!is_free(x, y)) continue;
            px[d] = x;
            py[d] = y;
            int k = cell_of(x, y);
            next[d] = head[k];
            head[k] = d++;
        }
        for (int tracer = 0; tracer < tracers; tracer++) {
            double x, y, rx = 0.0, ry = 0.0, t = 0.0, vx = gaussian(), vy = gaussian();
            do {
                x = side * uniform();
                y = side * uniform();
            } while (!is_free(x, y));
            int last = -1;
            for (int k = 0; k < times; k++) {
                double end = atof(argv[7 + k]);
                while (t < end) {
                    double v = sqrt(vx * vx + vy * vy), distance;
                    if (v < 1e-9) break; /* caught between disks */
                    int hit = first_contact(x, y, vx / v, vy / v, last, v * (end - t), &distance);
                    x += vx / v * distance;
                    y += vy / v * distance;
                    rx += vx / v * distance;
                    ry += vy / v * distance;
                    x -= side * floor(x / side);
                    y -= side * floor(y / side);
                    if (hit < 0) {
                        t = end;
                        break;
                    }
                    t += distance / v;
                    double sx = nearest(x - px[hit]), sy = nearest(y - py[hit]);
                    double r = sqrt(sx * sx + sy * sy), normal = (vx * sx + vy * sy) / r;
                    vx -= (1.0 + e) * normal * sx / r;
                    vy -= (1.0 + e) * normal * sy / r;
                    last = hit;
                }
                printf("%d %d %g %.9g %.9g %.9g %.9g\n", medium, medium * tracers + tracer, end, rx, ry, vx, vy);
            }
        }
    }
    return 0;
}
