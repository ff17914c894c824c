/* Creep of the core in plain C, as `slip` of railcli/kernels/contact.py with railcli/kernels/creep.py. */

#include <math.h>
#include "twin.h"
#include "vec.h"

static const double SHEN_END = 3.0;

static double saturation(int64_t law, double ratio, double *slope)
{
    if (law == SMOOTH && ratio < SHEN_END) {
        *slope = 2.0 * ratio / 27.0 - 1.0 / 3.0;
        return 1.0 - ratio * (1.0 / 3.0 - ratio / 27.0);
    }
    if (law == HARD && ratio < 1.0) {
        *slope = 0.0;
        return 1.0;
    }
    double factor = 1.0 / ratio;
    *slope = -factor * factor;
    return factor;
}

/* force: tx, ty, mz; jacobian: rows tx, ty, mz, columns xi, eta, phi. */
static void forces_and_jacobian(int64_t law, const struct contact *c, double limit, double xi, double eta, double phi,
                                double force[3], double jacobian[3][3])
{
    if (limit <= 0.0) {
        for (int i = 0; i < 3; i++) force[i] = jacobian[i][0] = jacobian[i][1] = jacobian[i][2] = 0.0;
        return;
    }
    double linear[3] = {-c->f11 * xi, -c->f22 * eta - c->f23 * phi, c->f23 * eta - c->f33 * phi};
    double size = sqrt(linear[0] * linear[0] + linear[1] * linear[1]), slope;
    double factor = saturation(law, size / limit, &slope);
    double pull = size > 0.0 ? slope / (limit * size) : 0.0;
    double by[3] = {-pull * linear[0] * c->f11, -pull * linear[1] * c->f22, -pull * linear[1] * c->f23};
    for (int i = 0; i < 3; i++) {
        force[i] = factor * linear[i];
        for (int k = 0; k < 3; k++) jacobian[i][k] = by[k] * linear[i];
    }
    jacobian[0][0] -= factor * c->f11;
    jacobian[1][1] -= factor * c->f22;
    jacobian[1][2] -= factor * c->f23;
    jacobian[2][1] += factor * c->f23;
    jacobian[2][2] -= factor * c->f33;
}

void slip(const struct model *model, struct data *data)
{
    const struct param *param = model->param;
    for (int64_t i = 0; i < model->n_body; i++) {
        if (!model->body[i].spins) continue;
        for (int a = 0; a < 6; a++)
            for (int b = 0; b < 6; b++) data->creep_damping[i][a][b] = 0.0;
    }
    for (int64_t w = 0; w < model->n_wheel; w++) {
        const struct wheel *wheel = &model->wheel[w];
        struct rail *rail = &data->rail[w];
        int64_t i = wheel->body;
        if (rail->patches == 0.0) continue;
        const struct frame *frame = &data->frame[i];
        double sr = frame->sine[0], sy = frame->sine[2], cr = frame->cosine[0], cy = frame->cosine[2];
        vec forward = {cy, sy, 0.0}, axle = {-sy * cr, cy * cr, sr}, down = {sy * sr, -cy * sr, cr};
        vec v = get(data->v[i]);
        vec omega = add(add(scale(data->v[i][3], forward), scale(data->v[i][4], axle)), scale(data->v[i][5], down));
        double way = v.x >= 0.0 ? 1.0 : -1.0, per_speed = 1.0 / fmax(sqrt(dot(v, v)), param->creep_speed);
        vec right, below, ahead = rail_axes(rail, &right, &below);
        vec k = get(frame->rate), advance = get(frame->advance), force = {0, 0, 0}, moment = {0, 0, 0};
        for (int j = 0; j < (int)rail->patches; j++) {
            struct contact *contact = &data->contact[w][j];
            double slope = contact->slope, cosine = 1.0 / sqrt(1.0 + slope * slope), n = contact->normal;
            vec arm = get(contact->arm), bent = {0.0, arm.x * rail->lateral_bend, arm.x * rail->vertical_bend};
            vec normal = sub(scale(cosine, below), scale(slope * cosine, right));
            normal = sub(normal, scale(dot(normal, bent), ahead));
            double y = data->q[i][1] + arm.y, z = data->q[i][2] + arm.z;
            vec turned = {0.0, advance.y + k.z * arm.x - k.x * z, advance.z + k.x * y - k.y * arm.x};
            vec along = scale(way, add(ahead, add(turned, bent)));
            vec across = cross(normal, along);
            vec arm_x = cross(arm, along), arm_t = cross(arm, across);
            double t[3], slope_of[3][3];
            contact->slip_x = dot(along, v) + dot(arm_x, omega);
            contact->slip_t = dot(across, v) + dot(arm_t, omega);
            contact->xi = contact->slip_x * per_speed;
            contact->eta = contact->slip_t * per_speed;
            contact->phi = dot(normal, omega) * per_speed;
            forces_and_jacobian(param->creep_law, contact, rail->grip[0] * n, contact->xi, contact->eta,
                                contact->phi, t, slope_of);
            contact->creep_x = t[0], contact->creep_t = t[1], contact->spin_moment = t[2];
            vec here = add(add(scale(t[0], along), scale(t[1], across)), scale(-n, normal));
            double pull = n * (normal.y * advance.y + normal.z * advance.z);
            vec lean = {pull, 0.0, 0.0}, yawing = {0.0, 0.0, -arm.y * pull};
            force = add(force, add(here, lean));
            moment = add(moment, add(cross(arm, here), add(scale(t[2], normal), yawing)));
            double g[3][6] = {
                {along.x, along.y, along.z, dot(forward, arm_x), dot(axle, arm_x), dot(down, arm_x)},
                {across.x, across.y, across.z, dot(forward, arm_t), dot(axle, arm_t), dot(down, arm_t)},
                {0.0, 0.0, 0.0, dot(forward, normal), dot(axle, normal), dot(down, normal)},
            };
            double h[3][6];
            for (int k = 0; k < 3; k++)
                for (int b = 0; b < 6; b++)
                    h[k][b] = per_speed * (slope_of[k][0] * g[0][b] + slope_of[k][1] * g[1][b] + slope_of[k][2] * g[2][b]);
            for (int a = 0; a < 6; a++)
                for (int b = 0; b < 6; b++)
                    data->creep_damping[i][a][b] -= g[0][a] * h[0][b] + g[1][a] * h[1][b] + g[2][a] * h[2][b];
        }
        rail->x = -force.x, rail->y = -force.y, rail->q = -force.z;
        accumulate(data->load[i], force);
        accumulate(data->load[i] + 3, make(dot(forward, moment), dot(axle, moment), dot(down, moment)));
    }
}
