/* Stages of the core in plain C: its yardstick of speed. Names, frames and signs are those of railcli/kernels. The
 * records come from layout.h, which c_twin.py writes from railcli/kernels/layout.py. */
#pragma once

#include "layout.h"

void suspension(const struct model *model, struct data *data, double half_step);
int64_t touch(const struct model *model, struct data *data);
void slip(const struct model *model, struct data *data);
int64_t repeat(const struct model *model, struct data *data, int64_t stage, int64_t times);
