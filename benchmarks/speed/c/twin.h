/* Stages of the core in plain C: its yardstick of speed. Names, frames and signs are those of railcli/kernels. The
 * records come from layout.h, which c_twin.py writes from railcli/kernels/layout.py. */
#pragma once

#include <math.h>
#include "layout.h"
#include "vec.h"

/* Axis along a rail that yaws and pitches with its slopes; those to the right and down in *right and *below. */
static inline vec rail_axes(const struct rail *rail, vec *right, vec *below)
{
    double cy = 1.0 / sqrt(1.0 + rail->lateral_slope * rail->lateral_slope), sy = rail->lateral_slope * cy;
    double rise = rail->vertical_slope * cy, cp = 1.0 / sqrt(1.0 + rise * rise), sp = rise * cp;
    *right = make(-sy, cy, 0.0);
    *below = make(-cy * sp, -sy * sp, cp);
    return make(cy * cp, sy * cp, sp);
}

void suspension(const struct model *model, struct data *data, double half_step);
int64_t touch(const struct model *model, struct data *data);
void slip(const struct model *model, struct data *data);
int64_t repeat(const struct model *model, struct data *data, int64_t stage, int64_t times);
