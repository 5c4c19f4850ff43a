/* doctor_arithmetic.c - runs a small kernel and compares its results with the host's, bit for bit. */
#include "doctor_arithmetic.h"

#include "scene.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT = 1 << 16, INPUTS = 3, OUTPUTS = 4 };

/* Not one of the renderer's kernels: it must build even where those do not. */
static const char source[] = "#ifdef DOUBLE\n"
                             "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n"
                             "typedef double real;\n"
                             "#else\n"
                             "typedef float real;\n"
                             "#endif\n"
                             "#pragma OPENCL FP_CONTRACT OFF\n"
                             "kernel void check(global const real *in, global real *out, real tiny) {\n"
                             "    size_t i = get_global_id(0);\n"
                             "    real a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];\n"
                             "    out[4 * i] = a / b;\n"
                             "    out[4 * i + 1] = sqrt(a);\n"
                             "    out[4 * i + 2] = a * b + c;\n"
                             "    out[4 * i + 3] = tiny * (a / a);\n"
                             "}\n";

/* Uniform in the exponent: 2^-20 … 2^20, from a fixed sequence. */
static double next_value(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    double mantissa = 1 + (double)(*state >> 12) / 4503599627370496.0;
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return ldexp(mantissa, (int)(*state >> 58) % 41 - 20);
}

static void fill_inputs(void *inputs, bool doubles) {
    uint64_t state = 1;
    for (size_t i = 0; i < (size_t)COUNT * INPUTS; i++) {
        double value = next_value(&state);
        if (doubles)
            ((double *)inputs)[i] = value;
        else
            ((float *)inputs)[i] = (float)value;
    }
    /* c = -(a*b) rounded: a fused a*b+c then gives the rounding error, an unfused one zero. */
    for (size_t i = 0; i < COUNT; i++) {
        if (doubles) {
            double *v = (double *)inputs + INPUTS * i;
            v[2] = -(v[0] * v[1]);
        } else {
            float *v = (float *)inputs + INPUTS * i;
            v[2] = -(v[0] * v[1]);
        }
    }
}

static void compare(const void *inputs, const void *outputs, bool doubles, arithmetic *result) {
    *result = (arithmetic){.count = COUNT};
    for (size_t i = 0; i < COUNT; i++) {
        bool wrong[OUTPUTS];
        if (doubles) {
            const double *in = (const double *)inputs + INPUTS * i, *out = (const double *)outputs + OUTPUTS * i;
            const double right[OUTPUTS] = {in[0] / in[1], sqrt(in[0]), in[0] * in[1] + in[2], DBL_MIN / 8};
            for (int k = 0; k < OUTPUTS; k++)
                wrong[k] = memcmp(&right[k], &out[k], sizeof right[k]) != 0;
        } else {
            const float *in = (const float *)inputs + INPUTS * i, *out = (const float *)outputs + OUTPUTS * i;
            const float right[OUTPUTS] = {in[0] / in[1], sqrtf(in[0]), in[0] * in[1] + in[2], FLT_MIN / 8};
            for (int k = 0; k < OUTPUTS; k++)
                wrong[k] = memcmp(&right[k], &out[k], sizeof right[k]) != 0;
        }
        result->wrong_divisions += wrong[0];
        result->wrong_roots += wrong[1];
        result->fused += wrong[2];
        result->flushed += wrong[3];
    }
}

static cl_program build(const feeler_device *device, bool doubles, feeler_error *error) {
    cl_device_fp_config singles = 0;
    const char *text = source;
    cl_int status;
    cl_program program = clCreateProgramWithSource(device->context, 1, &text, NULL, &status);
    if (!program) {
        fail_cl(error, "clCreateProgramWithSource", status);
        return NULL;
    }
    (void)clGetDeviceInfo(device->id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof singles, &singles, NULL);
    bool rounded = (singles & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
    const char *options = doubles ? "-DDOUBLE" : rounded ? "-cl-fp32-correctly-rounded-divide-sqrt" : "";
    status = clBuildProgram(program, 1, &device->id, options, NULL, NULL);
    if (status == CL_SUCCESS)
        return program;

    fail_cl(error, "clBuildProgram", status);
    (void)clGetProgramBuildInfo(program, device->id, CL_PROGRAM_BUILD_LOG, sizeof error->log - 1, error->log, NULL);
    (void)clReleaseProgram(program);
    return NULL;
}

static int set_arguments(cl_kernel kernel, cl_mem in, cl_mem out, bool doubles, feeler_error *error) {
    float tiny = FLT_MIN / 8;
    double tiny_double = DBL_MIN / 8;
    cl_int status = clSetKernelArg(kernel, 0, sizeof in, &in);
    if (status == CL_SUCCESS)
        status = clSetKernelArg(kernel, 1, sizeof out, &out);
    if (status == CL_SUCCESS)
        status = doubles ? clSetKernelArg(kernel, 2, sizeof tiny_double, &tiny_double)
                         : clSetKernelArg(kernel, 2, sizeof tiny, &tiny);
    return status == CL_SUCCESS ? 0 : fail_cl(error, "clSetKernelArg", status);
}

static int run(const feeler_device *device, cl_kernel kernel, void *inputs, void *outputs, bool doubles,
               feeler_error *error) {
    const size_t items = COUNT, group = device->max_work_group < 64 ? 1 : 64;
    size_t real = doubles ? sizeof(double) : sizeof(float);
    cl_int status;
    int result = -1;
    cl_event ran = NULL;
    cl_mem out = NULL;
    cl_mem in = clCreateBuffer(device->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, COUNT * INPUTS * real, inputs,
                               &status);
    if (in)
        out = clCreateBuffer(device->context, CL_MEM_WRITE_ONLY, COUNT * OUTPUTS * real, NULL, &status);
    if (!in || !out) {
        fail_cl(error, "clCreateBuffer", status);
        goto done;
    }
    if (set_arguments(kernel, in, out, doubles, error))
        goto done;
    status = clEnqueueNDRangeKernel(device->queue, kernel, 1, NULL, &items, &group, 0, NULL, &ran);
    if (status != CL_SUCCESS) {
        fail_cl(error, "clEnqueueNDRangeKernel", status);
        goto done;
    }
    status = clEnqueueReadBuffer(device->queue, out, CL_TRUE, 0, COUNT * OUTPUTS * real, outputs, 1, &ran, NULL);
    result = status == CL_SUCCESS ? 0 : fail_cl(error, "clEnqueueReadBuffer", status);
done:
    if (ran)
        (void)clReleaseEvent(ran);
    if (out)
        (void)clReleaseMemObject(out);
    if (in)
        (void)clReleaseMemObject(in);
    return result;
}

int arithmetic_try(const feeler_device *device, bool doubles, arithmetic *result, feeler_error *error) {
    size_t real = doubles ? sizeof(double) : sizeof(float);
    int code = -1;
    cl_int status;
    cl_kernel kernel = NULL;
    cl_program program = NULL;
    void *inputs = malloc(COUNT * INPUTS * real), *outputs = calloc(COUNT, OUTPUTS * real);
    if (!inputs || !outputs) {
        fail(error, FEELER_OUT_OF_MEMORY, "out of memory");
        goto done;
    }
    fill_inputs(inputs, doubles);
    program = build(device, doubles, error);
    if (!program)
        goto done;
    kernel = clCreateKernel(program, "check", &status);
    if (!kernel) {
        fail_cl(error, "clCreateKernel", status);
        goto done;
    }
    if (run(device, kernel, inputs, outputs, doubles, error))
        goto done;
    compare(inputs, outputs, doubles, result);
    code = 0;
done:
    if (kernel)
        (void)clReleaseKernel(kernel);
    if (program)
        (void)clReleaseProgram(program);
    free(inputs);
    free(outputs);
    return code;
}
