/* What kernels need beyond arithmetic: blocks of memory with counted references, and arrays seen in another shape.
   The names are those that numba's code calls (numba/core/runtime/nrt.h). */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

typedef void (*Destructor)(void *data, size_t size, void *information);
typedef struct {
    int64_t n_references; /* first: the kernels count them */
    Destructor destructor;
    void *information, *data;
    size_t size;
    void *external;
} Block;

__attribute__((visibility("default"))) int64_t n_live_blocks; /* blocks of memory that kernels hold; 0 between calls */

static void count_blocks(int64_t change) { __atomic_fetch_add(&n_live_blocks, change, __ATOMIC_RELAXED); }

static Block *new_block(size_t extra, void *data, size_t size, Destructor destructor, void *information) {
    Block *block = malloc(sizeof(Block) + extra);
    if (!block) return NULL;
    count_blocks(1);
    *block = (Block){1, destructor, information, data, size, NULL};
    return block;
}

void release_block(Block *block) {
    if (block->destructor) block->destructor(block->data, block->size, block->information);
    count_blocks(-1);
    free(block);
}

void drop_reference(Block *block) {
    if (block && --block->n_references == 0) release_block(block);
}

void *NRT_Allocate(size_t size) { return malloc(size); }
void NRT_Free(void *data) { free(data); }

void *NRT_MemInfo_alloc_aligned(size_t size, unsigned alignment) {
    size_t step = alignment < 16 ? 16 : alignment;
    Block *block = new_block(size + step, NULL, size, NULL, NULL);
    if (block) block->data = (void *)(((uintptr_t)(block + 1) + step - 1) / step * step);
    return block;
}

void *NRT_MemInfo_alloc(size_t size) { return NRT_MemInfo_alloc_aligned(size, 16); }

static void free_variable(void *data, size_t size, void *inner) {
    if (inner) ((Destructor)(intptr_t)inner)(data, size, NULL);
    free(data);
}

void *NRT_MemInfo_new_varsize_dtor(size_t size, Destructor destructor) {
    void *data = malloc(size);
    Block *block = data ? new_block(0, data, size, free_variable, (void *)(intptr_t)destructor) : NULL;
    if (!block) free(data);
    return block;
}

void *NRT_MemInfo_new_varsize(size_t size) { return NRT_MemInfo_new_varsize_dtor(size, NULL); }

static void *resize(Block *block, void *data, size_t size) {
    if (!data) return NULL;
    block->data = data;
    block->size = size;
    return data;
}

void *NRT_MemInfo_varsize_realloc(Block *block, size_t size) { return resize(block, realloc(block->data, size), size); }
void *NRT_MemInfo_varsize_alloc(Block *block, size_t size) { return resize(block, malloc(size), size); }

void NRT_MemInfo_varsize_free(Block *block, void *data) {
    free(data);
    if (data == block->data) block->data = NULL;
}

void *NRT_MemInfo_data_fast(Block *block) { return block->data; }

/* Strides of the entries of a contiguous array in another shape; 0 if it is not contiguous. */
int numba_attempt_nocopy_reshape(int64_t n_axes, const int64_t *shape, const int64_t *strides, int64_t n_new_axes, const int64_t *new_shape,
                                 int64_t *new_strides, int64_t item_size, int is_fortran) {
    int64_t stride = item_size, n_items = 1, n_new_items = 1;
    if (is_fortran) return 0;
    for (int64_t i = n_axes; i-- > 0;) {
        if (shape[i] != 1 && strides[i] != stride) return 0;
        stride *= shape[i];
        n_items *= shape[i];
    }
    stride = item_size;
    for (int64_t i = n_new_axes; i-- > 0;) {
        new_strides[i] = stride;
        stride *= new_shape[i];
        n_new_items *= new_shape[i];
    }
    return n_items == n_new_items;
}
