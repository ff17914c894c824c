/* The suspension of the core in plain C, as railcli/kernels/suspension.py. */

#include <math.h>
#include "twin.h"
#include "vec.h"

static inline double read_curve(const struct curve *curve, double x, double *slope)
{
    int i = 0;
    while (i < curve->count - 2 && x > curve->x[i + 1]) i++;
    *slope = (curve->y[i + 1] - curve->y[i]) / (curve->x[i + 1] - curve->x[i]);
    return curve->y[i] + *slope * (x - curve->x[i]);
}

static inline vec rotate(vec h, double h0, vec v)
{
    vec t = scale(2.0, cross(h, v));
    return add(v, add(scale(h0, t), cross(h, t)));
}

static inline vec bushing_force(const struct model *model, const struct element *e, vec d, vec rate)
{
    double at[3] = {d.x, d.y, d.z}, moving[3] = {rate.x, rate.y, rate.z}, force[3], slope;
    for (int a = 0; a < 3; a++) {
        force[a] = e->preload[a] - e->k[a] * at[a] - e->c[a] * moving[a];
        if (e->spring_curve[a] >= 0) force[a] -= read_curve(&model->curve[e->spring_curve[a]], at[a], &slope);
    }
    return get(force);
}

static inline vec link_force(const struct model *model, struct data *data, const struct element *e, vec gap,
                             vec gap_rate, double half_step)
{
    double length = sqrt(dot(gap, gap)), slope, rate;
    vec along = scale(1.0 / length, gap);
    double stretch = length - e->length, tension = e->preload[0] + e->k[0] * stretch;
    if (e->spring_curve[0] >= 0) tension += read_curve(&model->curve[e->spring_curve[0]], stretch, &slope);
    if (e->state >= 0) {
        double trial = e->series * (length - data->damper[e->state]);
        if (e->damper_curve[0] >= 0) {
            rate = read_curve(&model->curve[e->damper_curve[0]], trial, &slope);
        } else {
            slope = 1.0 / e->c[0];
            rate = trial * slope;
        }
        rate /= 1.0 + half_step * slope * e->series;
        tension += trial - half_step * rate * e->series;
        data->damper_rate[e->state] = rate;
    } else if (e->damper_curve[0] >= 0) {
        tension += read_curve(&model->curve[e->damper_curve[0]], dot(along, gap_rate), &slope);
    } else {
        tension += e->c[0] * dot(along, gap_rate);
    }
    return scale(-tension, along);
}

static void joint_elements(const struct model *model, struct data *data, const struct joint *joint, double half_step)
{
    struct frame *lower = &data->frame[joint->lower], *upper = &data->frame[joint->upper];
    double trace = 0.0;
    for (int k = 0; k < 3; k++) trace += dot(get(lower->axes[k]), get(upper->axes[k]));
    double q0 = 0.5 * sqrt(fmax(1.0 + trace, 0.01));
    vec a = inward(lower->axes, column(upper->axes, 1)), b = inward(lower->axes, column(upper->axes, 2));
    vec c = inward(lower->axes, column(upper->axes, 0));
    vec qv = scale(0.25 / q0, make(a.z - b.y, b.x - c.z, c.y - a.x));
    double h0 = sqrt(0.5 * (1.0 + q0));
    vec hv = scale(0.5 / h0, qv), back = scale(-1.0, hv);
    int mean = joint->axes == MEAN;
    vec omega_a = get(lower->omega_frame), omega_b = get(upper->omega_frame), omega = omega_b, tilt = {0, 0, 0};
    if (mean) {
        tilt = outward(lower->axes, scale(1.0 / h0, hv));
        vec relative = sub(omega_b, omega_a);
        omega = add(omega_a, scale(0.5, sub(relative, cross(tilt, relative))));
    }
    vec force_b = {0, 0, 0}, moment_a = {0, 0, 0}, moment_b = {0, 0, 0}, couple = {0, 0, 0};
    for (int64_t n = joint->first; n < joint->first + joint->count; n++) {
        const struct element *e = &model->element[n];
        vec arm_a = outward(lower->axes, get(e->lower)), arm_b = outward(upper->axes, get(e->upper));
        vec gap = sub(add(get(upper->position), arm_b), add(get(lower->position), arm_a));
        vec gap_rate = sub(add(get(upper->velocity), cross(omega_b, arm_b)),
                           add(get(lower->velocity), cross(omega_a, arm_a)));
        vec force;
        if (e->kind == LINK) {
            force = link_force(model, data, e, gap, gap_rate, half_step);
        } else {
            gap_rate = sub(gap_rate, cross(omega, gap));
            if (mean) {
                vec d = rotate(back, h0, inward(lower->axes, gap));
                vec rate = rotate(back, h0, inward(lower->axes, gap_rate));
                force = outward(lower->axes, rotate(hv, h0, bushing_force(model, e, d, rate)));
            } else {
                vec d = inward(upper->axes, gap), rate = inward(upper->axes, gap_rate);
                force = outward(upper->axes, bushing_force(model, e, d, rate));
            }
            couple = add(couple, cross(force, gap));
        }
        force_b = add(force_b, force);
        moment_a = sub(moment_a, cross(arm_a, force));
        moment_b = add(moment_b, cross(arm_b, force));
    }
    vec share = mean ? scale(0.5, add(couple, cross(tilt, couple))) : couple;
    if (mean) moment_a = add(moment_a, sub(couple, share));
    moment_b = add(moment_b, share);
    const double *turn = joint->turn;
    if (turn[0] != 0.0 || turn[1] != 0.0 || turn[2] != 0.0) {
        vec stiff = make(2.0 * turn[0] * qv.x, 2.0 * turn[1] * qv.y, 2.0 * turn[2] * qv.z);
        stiff = sub(stiff, scale(dot(qv, stiff) / (1.0 + q0), qv));
        stiff = outward(lower->axes, rotate(hv, h0, stiff));
        moment_a = add(moment_a, stiff);
        moment_b = sub(moment_b, stiff);
    }
    accumulate(upper->force, force_b);
    accumulate(lower->force, scale(-1.0, force_b));
    accumulate(lower->moment, moment_a);
    accumulate(upper->moment, moment_b);
}

void suspension(const struct model *model, struct data *data, double half_step)
{
    for (int64_t j = 0; j < model->n_joint; j++) joint_elements(model, data, &model->joint[j], half_step);
}
