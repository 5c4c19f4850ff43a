/* mesh_io.h - how assimp opens files here. */
#ifndef FEELER_MESH_IO_H
#define FEELER_MESH_IO_H

#include <assimp/cfileio.h>
#include <stdbool.h>

typedef struct mesh_io {
    struct aiFileIO calls; /* to be given to assimp */
    bool out_of_memory;
    char missing[512]; /* the first material library (.mtl) that could not be opened; empty: none */
} mesh_io;

/* The structure must stay where it is while assimp reads. */
void mesh_io_start(mesh_io *io);

#endif
