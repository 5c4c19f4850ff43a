/* yaml_nodes.h - YAML text into nodes. */
#ifndef FEELER_YAML_NODES_H
#define FEELER_YAML_NODES_H

#include "node.h"

/* Reads a YAML file of one document into nodes of the pool. `source` names the file in errors and must outlive the nodes.
 * Anchors and aliases work; tags and merge keys are errors. NULL on failure; the pool may then hold rubbish. */
const feeler_node *yaml_read_file(const char *path, const char *source, node_pool *pool, feeler_error *error);

#endif
