/* The march in time of layerjam/mechanics/motion.py at constant vacuum, without rope damping, as
   one would write it in C: the same steps, the same three Newton steps in each of them that slides.
   A drop is left at its first standstill or the end of its travel, to the step. */
#include <math.h>

typedef struct {
    double friction, overlap, travel, stiffness, drag, reach, spring, gravity;
} Brake;

typedef struct {
    double c, k, overlap, root, saturation, slope, push;
} Setting;

static double backbone(double x, const Setting *a)
{
    return x < a->saturation ? a->root * sqrt(x) : a->slope * x + a->push;
}

static double backbone_work(double x, const Setting *a)
{
    double start = x < a->saturation ? x : a->saturation;
    double beyond = x - start;
    return a->root * start * sqrt(start) * 2 / 3
        + (a->slope * (x + start) / 2 + a->push) * beyond;
}

/* x >= 0 with spring x + f(x) = drive */
static double rising_root(double drive, double spring, const Setting *a)
{
    double push = drive > 0 ? drive : 0;
    double below = a->root + sqrt(a->root * a->root + 4 * spring * push);
    double root = 2 * push / (below > 0 ? below : 1);
    if (root * root < a->saturation) return root * root;
    double linear = (push - a->push) / (spring + a->slope);
    return linear > 0 ? linear : 0;
}

void step(long n, const double *mass, const double *speed, const double *vacuum, const Brake *of,
          double dt, long steps, double *slip, double *peak, double *time)
{
    #pragma omp parallel for schedule(static, 64)
    for (long i = 0; i < n; i++) {
        double m = mass[i], v = speed[i], g = of->gravity;
        double q = of->drag * vacuum[i];
        Setting a = { of->friction * vacuum[i], of->spring, of->overlap,
                      2 * sqrt(of->stiffness * q), q * of->reach * of->reach / of->stiffness,
                      of->stiffness / of->reach, q * of->reach };
        double k = a.k, c = a.c, s = 0, u = 0, place = 0, force = 0, heat = 0, top = 0, t = 0;
        int slack = 0;
        double ratio = a.root / (2 * c), crest = ratio * ratio;
        for (long j = 0; j < steps; j++) {
            double t1 = t, v1, u1 = u, s1 = s, force1 = force, place1, top1 = top, heat1 = heat;
            int slack1 = slack;
            if (slack) {
                double gap = s - place, sum = v + sqrt(v * v + 2 * g * gap);
                double tau = sum > 0 ? 2 * gap / sum : INFINITY;
                slack1 = !(tau <= dt && sum > 0);
                if (slack1) tau = dt;
                place1 = slack1 ? place + v * tau + g * tau * tau / 2 : s;
                v1 = v + g * tau;
                t1 = t + tau;
                u1 = s;
            } else {
                double alpha = m * (g + 2 * v / dt), beta = 2 * m / (dt * dt);
                double hold = c * (a.overlap - s) + backbone(s, &a);
                double way = (alpha - force) / (beta + k / 2);
                if (force + k * way > hold) {
                    double least = (hold - force) / k, far = (alpha - hold) / beta;
                    if (far < least * (1 + 1e-9)) far = least * (1 + 1e-9);
                    double before = backbone_work(s, &a);
                    for (int r = 0; r < 4; r++) {
                        s1 = rising_root(k * (u + far) - c * a.overlap, k - c, &a);
                        if (s1 < s) s1 = s;
                        double more = s1 - s;
                        force1 = force + k * (far - more);
                        double rubbed = c * more * (a.overlap - (s1 + s) / 2);
                        double sleeve = backbone_work(s1, &a) - before;
                        heat1 = heat + rubbed + (s1 < a.saturation ? sleeve / 2 : sleeve);
                        if (r == 3) break;
                        double work = (force1 - force) * (force1 + force) / (2 * k) + rubbed
                            + sleeve;
                        double mean = work / far;
                        far -= (mean + beta * far - alpha) / ((force1 - mean) / far + beta);
                        if (far < least) far = least;
                    }
                    way = far;
                } else {
                    force1 = force + k * way;
                }
                double mean = alpha - beta * way;
                if (force1 < 0) {
                    double pull = g - force / (2 * m), give = force / k;
                    double root = v * v - 2 * pull * give;
                    double tau = 2 * give / (sqrt(root > 0 ? root : 0) - v);
                    if (tau > dt) tau = dt;
                    v1 = v + pull * tau;
                    t1 = t + tau;
                    u1 = place1 = s;
                    force1 = 0;
                    slack1 = 1;
                } else {
                    u1 = place1 = u + way;
                    v1 = v + (g - mean / m) * dt;
                    t1 = t + dt;
                    double highest = s < crest && crest < s1
                        ? c * a.overlap + a.root * a.root / (4 * c) : force1;
                    if (highest > top) top1 = highest;
                }
            }
            if ((v > 0 && v1 <= 0) || s1 >= of->travel) break;
            t = t1; v = v1; u = u1; s = s1; force = force1; place = place1; top = top1;
            heat = heat1; slack = slack1;
        }
        slip[i] = s;
        peak[i] = top;
        time[i] = t + 0 * heat;
    }
}
