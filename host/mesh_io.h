/* mesh_io.h - how assimp opens files here. */
#ifndef FEELER_MESH_IO_H
#define FEELER_MESH_IO_H

#include <assimp/cfileio.h>
#include <stdbool.h>

typedef struct mesh_io {
    struct aiFileIO calls; /* to be given to assimp */
    bool out_of_memory;
    char missing[512]; /* the first material library (.mtl) that could not be opened; empty: none */
    char *text;        /* what assimp reads in place of an OBJ file */
} mesh_io;

/* The structure must stay where it is while assimp reads; end it when assimp's scene is freed. */
void mesh_io_start(mesh_io *io);
void mesh_io_end(mesh_io *io);

#endif
