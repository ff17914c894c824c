/* One stage many times, as railcli/kernels/stages.py. */

#include "twin.h"

int64_t repeat(const struct model *model, struct data *data, int64_t stage, int64_t times)
{
    double half_step = 0.5 * model->param->step;
    int64_t status = OK;
    for (int64_t n = 0; n < times && status == OK; n++) {
        switch (stage) {
        case SUSPENSION: suspension(model, data, half_step); break;
        case CONTACT: status = touch(model, data); break;
        case CREEP: slip(model, data); break;
        }
    }
    return status;
}
