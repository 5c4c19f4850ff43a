/* read_transform.c - the steps of a `transform` key, multiplied into one matrix. */
#include "schema.h"
#include "transform.h"
#include "vec.h"

static int read_rotation(const reader *reader, const feeler_node *node, matrix *step) {
    rotation turn = {{0, 0, 0}, 0};
    if (schema_read(reader, node, rotation_keys, &turn, NULL) != 0)
        return -1;
    *step = matrix_rotation(turn.axis, turn.angle);
    return 0;
}

static int read_axis_rotation(const reader *reader, const feeler_node *node, vec3 axis, matrix *step) {
    double angle = 0;
    if (read_number(reader, node, &angle) != 0)
        return -1;
    *step = matrix_rotation(axis, angle);
    return 0;
}

static int read_scaling(const reader *reader, const feeler_node *node, matrix *step) {
    vec3 factors = {0, 0, 0};
    if (read_colour(reader, node, &factors) != 0) /* one number or three, like a colour */
        return -1;
    if (factors.x == 0 || factors.y == 0 || factors.z == 0)
        return fail_node(reader, node_value(node), "'scale' by zero leaves nothing");
    *step = matrix_scaling(factors);
    return 0;
}

static int check_last_row(const reader *reader, const feeler_node *node, const double row[4]) {
    if (row[0] == 0 && row[1] == 0 && row[2] == 0 && row[3] == 1)
        return 0;
    return fail_item(reader, node, 3, "the last row of a 4 x 4 matrix must be 0 0 0 1");
}

static int read_matrix(const reader *reader, const feeler_node *node, matrix *step) {
    node = node_value(node);
    bool array = node->kind == NODE_ARRAY, list = node->kind == NODE_LIST;
    size_t rows = array ? node->array.rows : list ? node->children.count : 0;
    if ((rows != 3 && rows != 4) || (array && node->array.columns != 4))
        return fail_node(reader, node, "expected a matrix as 3 or 4 lists of 4 numbers");
    double last[4] = {0, 0, 0, 1};
    const feeler_node *child = list ? node->children.first : NULL;
    for (size_t i = 0; i < rows; i++) {
        double *to = i < 3 ? step->m[i] : last;
        if (child && read_numbers(reader, child, 4, to) != 0)
            return -1;
        for (size_t j = 0; array && j < 4; j++)
            to[j] = node->array.values[4 * i + j];
        child = child ? child->next : NULL;
    }
    return check_last_row(reader, node, last);
}

static int read_step(const reader *reader, const feeler_node *node, matrix *step) {
    const feeler_node *nodes[TRANSFORM_SLOTS] = {NULL};
    if (schema_read(reader, node, transform_keys, NULL, nodes) != 0)
        return -1;
    if (node_count(node_value(node)) != 1)
        return fail_node(reader, node_value(node),
                         "a step of a transform holds one key; write several as a list, the first applied first");
    vec3 offset = {0, 0, 0};
    for (int slot = 0; slot < TRANSFORM_SLOTS; slot++) {
        if (!nodes[slot])
            continue;
        switch (slot) {
        case TRANSFORM_TRANSLATE:
            if (read_vector(reader, nodes[slot], &offset) != 0)
                return -1;
            *step = matrix_translation(offset);
            return 0;
        case TRANSFORM_ROTATE:
            return read_rotation(reader, nodes[slot], step);
        case TRANSFORM_ROTATE_X:
            return read_axis_rotation(reader, nodes[slot], (vec3){1, 0, 0}, step);
        case TRANSFORM_ROTATE_Y:
            return read_axis_rotation(reader, nodes[slot], (vec3){0, 1, 0}, step);
        case TRANSFORM_ROTATE_Z:
            return read_axis_rotation(reader, nodes[slot], (vec3){0, 0, 1}, step);
        case TRANSFORM_SCALE:
            return read_scaling(reader, nodes[slot], step);
        default:
            return read_matrix(reader, nodes[slot], step);
        }
    }
    return 0;
}

int read_transform(const reader *reader, const feeler_node *node, matrix *total) {
    const feeler_node *value = node_value(node);
    bool list = value->kind == NODE_LIST;
    const feeler_node *item = list ? value->children.first : value;
    *total = matrix_identity();
    while (item) {
        matrix step = matrix_identity();
        if (read_step(reader, item, &step) != 0)
            return -1;
        *total = matrix_multiply(&step, total);
        if (!matrix_finite(total))
            return fail_node(reader, node_value(item), "the transform is not finite");
        if (matrix_singular(total))
            return fail_node(reader, node_value(item), "the transform is singular: it flattens the object");
        item = list ? item->next : NULL;
    }
    return 0;
}
