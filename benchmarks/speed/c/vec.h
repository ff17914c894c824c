/* Vectors of three; matrices hold axes in their columns. */
#pragma once

typedef struct { double x, y, z; } vec;

static inline vec make(double x, double y, double z) { return (vec){x, y, z}; }
static inline vec get(const double *a) { return (vec){a[0], a[1], a[2]}; }
static inline double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline vec scale(double k, vec a) { return (vec){k * a.x, k * a.y, k * a.z}; }
static inline vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline void accumulate(double *a, vec v) { a[0] += v.x, a[1] += v.y, a[2] += v.z; }
static inline vec outward(const double m[3][3], vec v)
{
    return (vec){dot(get(m[0]), v), dot(get(m[1]), v), dot(get(m[2]), v)};
}
static inline vec column(const double m[3][3], int k) { return (vec){m[0][k], m[1][k], m[2][k]}; }
static inline vec inward(const double m[3][3], vec v)
{
    return (vec){dot(column(m, 0), v), dot(column(m, 1), v), dot(column(m, 2), v)};
}
