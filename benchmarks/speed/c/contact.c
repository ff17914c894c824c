/* Normal contact of the core in plain C, as railcli/kernels/contact.py. */

#include <math.h>
#include "twin.h"
#include "vec.h"

enum { PART = GAP_Y }; /* of a sample: weight of the corners that have the branch */

static inline double power_1_5(double x) { return x * sqrt(x); }

static int look_up(const struct model *model, const struct table *table, double y, double roll, double yaw,
                   double depth, double (*sample)[NODE_CHANNELS])
{
    double py = (y - table->y_start) / table->y_step, pr = (roll - table->roll_start) / table->roll_step;
    double pw = yaw * yaw / table->yaw2_step;
    int64_t ny = table->y_count, nr = table->roll_count, nw = table->yaw2_count;
    if (!(py >= 0.0 && py <= ny - 1 && pr >= 0.0 && pr <= nr - 1 && pw <= nw - 1)) return -1;
    int64_t iy = py, ir = pr, iw = pw;
    iy = iy < ny - 2 ? iy : ny - 2, ir = ir < nr - 2 ? ir : nr - 2, iw = iw < nw - 2 ? iw : nw - 2;
    double ty = py - iy, tr = pr - ir, tw = pw - iw, full[8], u[3][8];
    for (int c = 0; c < 8; c++) {
        int by = c & 1, br = c >> 1 & 1, bw = c >> 2;
        full[c] = (by ? ty : 1.0 - ty) * (br ? tr : 1.0 - tr) * (bw ? tw : 1.0 - tw);
        u[0][c] = (ty - by) * table->y_step, u[1][c] = (tr - br) * table->roll_step;
        u[2][c] = (tw - bw) * table->yaw2_step;
    }
    const int32_t *cell = &model->cell[table->cell_base + (ir * (nw - 1) + iw) * (ny - 1) + iy];
    int count = 0;
    for (int64_t b = table->branch_base + cell[0]; b < table->branch_base + cell[1]; b++) {
        const double *node[8];
        double w[8], part = 0.0, half[3] = {0, 0, 0}, at[3] = {0, 0, 0};
        int whole = 1;
        for (int c = 0; c < 8; c++) {
            int32_t n = model->branch[b][c];
            node[c] = model->node[table->node_base + (n < 0 ? 0 : n)];
            w[c] = n < 0 ? 0.0 : full[c];
            whole &= n >= 0;
            part += w[c];
        }
        if (part < 1e-9) continue;
        if (whole) {
            part = 1.0;
        } else {
            for (int c = 0; c < 8; c++) w[c] /= part;
            for (int a = 0; a < 3; a++)
                for (int c = 0; c < 8; c++) half[a] += 0.5 * w[c] * u[a][c];
        }
        for (int c = 0; c < 8; c++) {
            double moved[3];
            for (int a = 0; a < 3; a++) moved[a] = 0.5 * u[a][c] + half[a];
            for (int k = 0; k < 3; k++) {
                const double *slope = node[c] + GAP_Y + k;
                at[k] += w[c] * (node[c][GAP + k] + moved[0] * slope[0] + moved[1] * slope[3] + moved[2] * slope[6]);
            }
        }
        double p = depth - at[0];
        if (!(p > 0.0)) continue;
        double *out = sample[count < MAX_CONTACT ? count : MAX_CONTACT - 1];
        for (int k = GAP; k < NODE_CHANNELS; k++) {
            out[k] = w[0] * node[0][k] + w[1] * node[1][k] + w[2] * node[2][k] + w[3] * node[3][k]
                   + w[4] * node[4][k] + w[5] * node[5][k] + w[6] * node[6][k] + w[7] * node[7][k];
        }
        out[RADIUS] += out[WHEEL_SLOPE] * (at[2] - 0.5 * out[LATERAL]);
        out[GAP] = p, out[PART] = part, out[SLOPE] = at[1], out[LATERAL] = at[2], count++;
    }
    return count;
}

static double facing_barrier(double (*sample)[NODE_CHANNELS], int count, int j, int way, int channel)
{
    double barrier = 0.0, rest = 1.0;
    for (int k = j + way; k >= 0 && k < count && rest > 0.0; k += way) {
        barrier += rest * sample[k][PART] * sample[k][channel];
        rest *= 1.0 - sample[k][PART];
    }
    return barrier;
}

static double elastic_share(double (*sample)[NODE_CHANNELS], int count, int j, double cosine)
{
    double p = sample[j][GAP], own = power_1_5(p * cosine);
    if (j > 0) {
        double near = sample[j][BARRIER_GAUGE], far = facing_barrier(sample, count, j, -1, BARRIER_FIELD);
        if (near < p) own -= far / fmax(near + far, 1e-12) * power_1_5((p - near) * cosine);
    }
    if (j < count - 1) {
        double near = sample[j][BARRIER_FIELD], far = facing_barrier(sample, count, j, 1, BARRIER_GAUGE);
        if (near < p) own -= far / fmax(near + far, 1e-12) * power_1_5((p - near) * cosine);
    }
    return sample[j][PART] * fmax(own, 0.0);
}

static double normal_force(const struct param *param, double hertz, double elastic, double approach)
{
    double damped;
    if (param->damping_rate_power == 1.0 && param->damping_depth_power == 1.5) {
        damped = elastic * approach;
    } else {
        damped = pow(elastic, 2.0 / 3.0 * param->damping_depth_power) * pow(fabs(approach), param->damping_rate_power);
        damped = approach > 0.0 ? damped : -damped;
    }
    return fmax(hertz * (elastic + param->damping * damped), 0.0);
}

static void hermite(const double *a, const double *b, double t, double h, double out[3])
{
    double da = h * a[1], db = h * b[1], c2 = 3.0 * (b[0] - a[0]) - 2.0 * da - db, c3 = 2.0 * (a[0] - b[0]) + da + db;
    out[0] = a[0] + t * (da + t * (c2 + t * c3));
    out[1] = (da + t * (2.0 * c2 + t * 3.0 * c3)) / h;
    out[2] = (2.0 * c2 + t * 6.0 * c3) / (h * h);
}

static int shift_rail(const struct model *model, double side, double s, struct rail *rail)
{
    double h = model->param->shift_step, place = (s - model->param->shift_start) / h, y[3], z[3];
    int64_t last = model->n_shift - 1, i = place;
    if (!(place >= 0.0 && place <= last)) return 0;
    i = i < last - 1 ? i : last - 1;
    const double *a = model->shift[i] + (side > 0.0 ? 0 : 4), *b = model->shift[i + 1] + (side > 0.0 ? 0 : 4);
    hermite(a, b, place - i, h, y);
    hermite(a + 2, b + 2, place - i, h, z);
    rail->lateral = y[0], rail->lateral_slope = y[1], rail->lateral_bend = y[2];
    rail->vertical = z[0], rail->vertical_slope = z[1], rail->vertical_bend = z[2];
    return 1;
}

int64_t touch(const struct model *model, struct data *data)
{
    const struct param *param = model->param;
    double (*sample)[NODE_CHANNELS] = data->sample;
    int shifted = model->n_shift > 0;
    for (int64_t w = 0; w < model->n_wheel; w++) {
        const struct wheel *wheel = &model->wheel[w];
        int64_t body = wheel->body;
        const struct frame *frame = &data->frame[body];
        const double *q = data->q[body], *rate = data->rate[body];
        double side = wheel->side, sr = frame->sine[0], sy = frame->sine[2], cr = frame->cosine[0], cy = frame->cosine[2];
        vec axle = {-sy * cr, cy * cr, sr}, e = axle, right, below;
        struct rail *rail = &data->rail[w];
        double roll = q[3], yaw = q[5], rail_y = q[1], rail_z = q[2], b0 = side * wheel->lateral;
        if (shifted && !shift_rail(model, side, q[0], rail)) return LEFT_SHIFT;
        vec ahead = rail_axes(rail, &right, &below);
        if (shifted) {
            vec from = make(0.0, q[1] - rail->lateral - b0, q[2] - rail->vertical);
            e = make(dot(ahead, axle), dot(right, axle), dot(below, axle));
            rail_y = dot(right, from) + b0, rail_z = dot(below, from);
            roll = asin(e.z), yaw = atan2(-e.x, e.y);
            sr = e.z, cr = sqrt(1.0 - e.z * e.z), cy = e.y / cr;
        }
        double y = side * rail_y + (wheel->lateral * cr - side * wheel->radius * sr) * cy - wheel->lateral;
        double z = rail_z + side * wheel->lateral * sr + wheel->radius * cr;
        int found = look_up(model, &model->table[wheel->table], y, side * roll, side * yaw, z, sample);
        rail->x = rail->y = rail->q = rail->patches = 0.0;
        rail->grip[0] = wheel->friction;
        sr = frame->sine[0], cr = frame->cosine[0], cy = frame->cosine[2];
        for (int j = found > 0 ? found : 0; j < MAX_CONTACT; j++) {
            data->contact[w][j].normal = 0.0;
            data->contact[w][j].depth = 0.0;
        }
        if (found < 0 || found > MAX_CONTACT) return LEFT_TABLE;
        if (z < -param->derail_lift) return DERAILED;
        vec turn = {rate[3] * cy, rate[3] * sy, rate[5]};
        for (int j = 0; j < found; j++) {
            const double *at = sample[j];
            struct contact *contact = &data->contact[w][j];
            double slope = side * at[SLOPE], cosine = 1.0 / sqrt(1.0 + slope * slope);
            vec normal = sub(scale(cosine, below), scale(slope * cosine, right));
            double lean = dot(normal, axle), down = at[RADIUS] / sqrt(1.0 - lean * lean);
            double along = side * (wheel->lateral + at[LATERAL]) - down * lean;
            vec arm = add(scale(along, axle), scale(down, normal));
            double bend = normal.y * rail->lateral_bend + normal.z * rail->vertical_bend;
            arm = sub(arm, scale(down * bend * arm.x / (1.0 + bend * down * ahead.x), ahead));
            vec moved = cross(turn, arm);
            moved.y += rate[1] - rate[0] * (rail->lateral_slope + arm.x * rail->lateral_bend);
            moved.z += rate[2] - rate[0] * (rail->vertical_slope + arm.x * rail->vertical_bend);
            double approach = dot(normal, moved);
            double elastic = elastic_share(sample, found, j, cosine), depth = at[GAP] * cosine;
            if (elastic < power_1_5(depth)) depth = pow(elastic, 2.0 / 3.0);
            double root = sqrt(depth);
            contact->normal = normal_force(param, at[HERTZ], elastic, approach);
            contact->semi_x = at[SEMI_X] * root, contact->semi_y = at[SEMI_Y] * root;
            contact->f11 = at[F11] * depth, contact->f22 = at[F22] * depth;
            contact->f23 = at[F23] * depth * root, contact->f33 = at[F33] * depth * depth;
            contact->depth = at[GAP];
            contact->slope = slope;
            contact->lateral = at[LATERAL];
            contact->radius = at[RADIUS];
            contact->region = at[REGION];
            contact->arm[0] = arm.x, contact->arm[1] = arm.y, contact->arm[2] = arm.z;
        }
        rail->patches = found;
    }
    return OK;
}
