/* Pictures of bodies made of triangles: depth buffer and edges. Apache License 2.0.
 *
 * report/picture_loops.py has the same loops in NumPy, with the same pixels. Rows count from the top.
 */

#include <math.h>
#include <stdint.h>

/* Draw `count` triangles of corners (n, 3) into the depth buffer; the first has number `first`. */
void lj_fill_triangles(const double *points, const int64_t *triangles, int64_t count, int64_t first,
                       int64_t rows, int64_t columns, float *depth, int32_t *face)
{
    for (int64_t i = 0; i < count; i++) {
        const double *p[4];
        for (int k = 0; k < 4; k++) {
            p[k] = &points[3 * triangles[3 * i + k % 3]];
        }
        const double *a = p[0], *b = p[1], *c = p[2];
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (area <= 1e-12) { /* seen from behind, or edge-on */
            continue;
        }
        const double low = fmax(floor(fmin(fmin(a[1], b[1]), c[1]) - 0.5), 0);
        const double high = fmin(ceil(fmax(fmax(a[1], b[1]), c[1]) - 0.5), (double)rows - 1);
        for (int64_t v = (int64_t)low; v <= high; v++) {
            /* where this row of samples enters and leaves the triangle */
            const double y = (double)v + 0.5;
            double start = 0.5, stop = (double)columns - 0.5;
            for (int k = 0; k < 3; k++) {
                /* a sample is inside an edge if (f - e) x (sample - e) >= 0, linear in x */
                const double *e = p[k], *f = p[k + 1];
                const double slope = e[1] - f[1];
                const double offset = (f[0] - e[0]) * (y - e[1]) - slope * e[0];
                if (slope > 0) {
                    start = fmax(start, -offset / slope);
                } else if (slope < 0) {
                    stop = fmin(stop, -offset / slope);
                } else if (offset < 0) {
                    stop = -1;
                }
            }
            const int64_t row = (rows - 1 - v) * columns;
            const double begin = ceil(start - 0.5), end = floor(stop - 0.5);
            for (int64_t u = begin > end ? 1 : (int64_t)begin, w = begin > end ? 0 : (int64_t)end;
                 u <= w; u++) {
                const double x = (double)u + 0.5;
                const double q = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / area;
                const double r = ((a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x)) / area;
                const double z = (1 - q - r) * a[2] + q * b[2] + r * c[2];
                const int64_t place = row + u;
                if (z > depth[place]) {
                    depth[place] = (float)z;
                    face[place] = (int32_t)(first + i);
                }
            }
        }
    }
}

/* Properties of the edges: cosine of the angle between faces, jump in depth, brightness. */
typedef struct {
    double crease, step, ink;
} lj_edges;

/* Whether an edge runs between a sample and the next one, `right` or below, on different faces. */
static int lj_is_edge(const float *depth, const int32_t *face, const double *normals,
                      const int32_t *owner, int64_t here, int64_t next, int right, double fine,
                      const lj_edges *edges)
{
    const int32_t first = face[here], second = face[next];
    if (first == second) {
        return 0;
    }
    if (first < 0 || second < 0 || owner[first] != owner[second]) {
        return 1;
    }
    const double *n = &normals[3 * (int64_t)first], *m = &normals[3 * (int64_t)second];
    if (n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < edges->crease) {
        return 1;
    }
    /* in a plane the depth changes in proportion to its slope */
    const double slope = -((right ? n[0] : -n[1]) / fmax(n[2], 0.05)) / fine;
    return fabs(depth[next] - depth[here] - slope) > edges->step + fabs(slope);
}

/* Write the shades and edges of finer^2 samples, averaged over each pixel, as (.., .., 3) bytes. */
void lj_average_pixels(const float *depth, const int32_t *face, int64_t rows, int64_t columns,
                       int64_t finer, const double *normals, const int32_t *owner,
                       const double *shades, double fine, const lj_edges *edges, uint8_t *pixels)
{
    const double samples = (double)(finer * finer);
    const double white[3] = {255, 255, 255}, ink[3] = {edges->ink, edges->ink, edges->ink};
    for (int64_t v = 0; v < rows / finer; v++) {
        for (int64_t u = 0; u < columns / finer; u++) {
            double sum[3] = {0, 0, 0};
            for (int64_t i = 0; i < finer * finer; i++) {
                const int64_t w = finer * v + i / finer, t = finer * u + i % finer;
                const int64_t here = w * columns + t;
                const int64_t right = here + (t + 1 < columns);
                const int64_t below = here + (w + 1 < rows ? columns : 0);
                const int32_t front = face[here];
                const double *shade = front < 0 ? white : &shades[3 * (int64_t)front];
                if ((face[right] != front || face[below] != front) &&
                    (lj_is_edge(depth, face, normals, owner, here, right, 1, fine, edges) ||
                     lj_is_edge(depth, face, normals, owner, here, below, 0, fine, edges))) {
                    shade = ink;
                }
                for (int k = 0; k < 3; k++) {
                    sum[k] += shade[k];
                }
            }
            for (int k = 0; k < 3; k++) {
                pixels[(v * (columns / finer) + u) * 3 + k] = (uint8_t)(sum[k] / samples + 0.5);
            }
        }
    }
}
