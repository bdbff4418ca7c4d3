/* Python calls a kernel: its arguments are written one by one into slots of 8 bytes, as numba flattens them, and its result is read behind
   them. What stands in the slots is described by a text, in the order of the arguments:

     d, q, b      a float, an integer (also an enum), a boolean
     a1Cd         an array: number of axes; order C or F of its entries, or A for any; kind of the entries: d, q, b, c for a complex
                  number, or r with the bytes of a record and a semicolon
     r96;         a record, with its bytes
     n            None: nothing that the kernel reads
     ( ... )      a tuple

   The result is described in the same way, with E before an integer that becomes an enum and T before the fields of a named tuple; their
   classes stand in the list `classes`, in the same order. Arguments of other types go to `fallback`. */
#include "python_abi.h"
#include <stdlib.h>
#include <string.h>

enum { RESULT_SLOTS = 64, MAX_AXES = 8 };

typedef struct {
    int (*entry)(int64_t *);
    const char *arguments, *result;
    PyObject *classes, *fallback, *new_array;
    int n_slots;
    PyMethodDef method;
} Kernel;

typedef struct {
    const char *format;
    int64_t *slot;
} Packing;

typedef struct {
    const char *format;
    const char *data;
    Py_ssize_t n_classes;
    const Kernel *kernel;
} Unpacking;

void drop_reference(void *);

static int read_number(const char **text) {
    int number = 0;
    while (**text >= '0' && **text <= '9') number = 10 * number + *(*text)++ - '0';
    if (**text == ';') ++*text;
    return number;
}

static int has_flag(PyObject *value, unsigned long flag) { return (PyType_GetFlags(value->type) & flag) != 0; }

/* Whether a letter stands for a format of numpy. */
static int is_kind(char kind, const char *format, Py_ssize_t size) {
    char found = format && *format ? *format : 'B';
    switch (kind) {
    case 'd': return found == 'd';
    case 'q': return found == 'q' || (found == 'l' && size == 8);
    case 'b': return found == '?';
    default: return found == 'Z' && size == 16;
    }
}

/* Describe an array, or point to a record, in slots; 0 if it is of another type. */
static int pack_buffer(Packing *packing, PyObject *value, int n_axes, char order, char kind) {
    Py_buffer view;
    int64_t *slot = packing->slot, n_items = 1;
    int size = kind == 'r' ? read_number(&packing->format) : 0;
    /* numpy would write the format of a record anew at every call: its size has to do */
    if (PyObject_GetBuffer(value, &view, kind == 'r' ? PyBUF_STRIDES : PyBUF_STRIDES | PyBUF_FORMAT)) {
        PyErr_Clear();
        return 0;
    }
    int fits = view.ndim == n_axes && (kind == 'r' ? view.itemsize == size : is_kind(kind, view.format, view.itemsize))
        && (order == 'A' || n_axes == 0 || PyBuffer_IsContiguous(&view, order));
    if (fits && order == 0) {
        *packing->slot++ = (int64_t)(intptr_t)view.buf;
    } else if (fits) {
        for (int i = 0; i < n_axes; i++) {
            slot[5 + i] = view.shape[i];
            slot[5 + n_axes + i] = view.strides[i];
            n_items *= view.shape[i];
        }
        slot[0] = slot[1] = 0; /* the kernel counts no references to it */
        slot[2] = n_items;
        slot[3] = view.itemsize;
        slot[4] = (int64_t)(intptr_t)view.buf;
        packing->slot += 5 + 2 * n_axes;
    }
    PyBuffer_Release(&view);
    return fits;
}

/* Write a number of Python or of numpy. */
static int pack_number(Packing *packing, PyObject *value, char kind) {
    int64_t bits = 0;
    if (kind == 'd' && (value->type == &PyFloat_Type || PyType_IsSubtype(value->type, &PyFloat_Type))) {
        double number = PyFloat_AsDouble(value);
        memcpy(&bits, &number, 8);
    } else if (value->type == &PyBool_Type) {
        if (kind != 'b') return 0;
        bits = PyLong_AsLongLong(value) != 0;
    } else if (kind == 'q' && has_flag(value, TYPE_IS_LONG)) {
        bits = PyLong_AsLongLong(value);
        if (bits == -1 && PyErr_Occurred()) {
            PyErr_Clear();
            return 0;
        }
    } else {
        Py_buffer view;
        if (has_flag(value, TYPE_IS_LONG) || PyObject_GetBuffer(value, &view, PyBUF_STRIDES | PyBUF_FORMAT)) {
            PyErr_Clear();
            return 0;
        }
        int fits = view.ndim == 0 && view.itemsize <= 8 && is_kind(kind, view.format, view.itemsize);
        if (fits) memcpy(&bits, view.buf, view.itemsize);
        PyBuffer_Release(&view);
        if (!fits) return 0;
    }
    *packing->slot++ = bits;
    return 1;
}

static int pack(Packing *, PyObject *);

/* Write the entries of a tuple up to the bracket that closes it, or the end of the description. */
static int pack_tuple(Packing *packing, PyObject *values) {
    Py_ssize_t n_values = PyTuple_Size(values), i = 0;
    for (; *packing->format && *packing->format != ')'; i++)
        if (i >= n_values || !pack(packing, PyTuple_GetItem(values, i))) return 0;
    if (*packing->format) packing->format++;
    return i == n_values;
}

static int pack(Packing *packing, PyObject *value) {
    char kind = *packing->format++;
    switch (kind) {
    case 'd': case 'q': case 'b':
        return pack_number(packing, value, kind);
    case '(':
        return has_flag(value, TYPE_IS_TUPLE) && pack_tuple(packing, value);
    case 'a': {
        int n_axes = *packing->format++ - '0';
        char order = *packing->format++, entries = *packing->format++;
        return pack_buffer(packing, value, n_axes, order, entries);
    }
    case 'r':
        return pack_buffer(packing, value, 0, 0, 'r');
    case 'n':
        *packing->slot++ = 0;
        return value == &_Py_NoneStruct;
    default:
        return 0;
    }
}

/* Copy an array that a kernel made, and give its memory back. */
static PyObject *unpack_array(Unpacking *unpacking) {
    int n_axes = *unpacking->format++ - '0';
    char entries = unpacking->format[1];
    const char *kind = entries == 'd' ? "f8" : entries == 'q' ? "i8" : entries == 'c' ? "c16" : "?";
    int64_t slots[5 + 2 * MAX_AXES];
    memcpy(slots, unpacking->data, 8 * (5 + 2 * n_axes));
    unpacking->format += 2;
    unpacking->data += 8 * (5 + 2 * n_axes);
    PyObject *shape = PyTuple_New(n_axes), *array = NULL;
    for (int i = 0; shape && i < n_axes; i++) PyTuple_SetItem(shape, i, PyLong_FromLongLong(slots[5 + i]));
    PyObject *bytes = PyByteArray_FromStringAndSize((const char *)(intptr_t)slots[4], slots[2] * slots[3]);
    PyObject *type = PyUnicode_FromString(kind);
    if (shape && bytes && type) array = PyObject_CallFunctionObjArgs(unpacking->kernel->new_array, shape, type, bytes, NULL);
    if (shape) Py_DecRef(shape);
    if (bytes) Py_DecRef(bytes);
    if (type) Py_DecRef(type);
    drop_reference((void *)(intptr_t)slots[0]);
    return array;
}

static PyObject *unpack(Unpacking *);

static PyObject *unpack_tuple(Unpacking *unpacking) {
    Py_ssize_t n_values = read_number(&unpacking->format);
    PyObject *values = PyTuple_New(n_values);
    for (Py_ssize_t i = 0; i < n_values; i++) {
        PyObject *value = unpack(unpacking); /* after a failure too: it gives memory back */
        if (value && values) PyTuple_SetItem(values, i, value);
        else if (values) { Py_DecRef(values); values = NULL; }
        else if (value) Py_DecRef(value);
    }
    return values;
}

static const char *aligned(const char *data) { return (const char *)(((intptr_t)data + 7) & ~(intptr_t)7); }

static PyObject *unpack(Unpacking *unpacking) {
    char kind = *unpacking->format++;
    if (kind == 'b') return PyBool_FromLong(*unpacking->data++ & 1);
    if (kind == 'n') { Py_IncRef(&_Py_NoneStruct); return &_Py_NoneStruct; }
    unpacking->data = aligned(unpacking->data);
    if (kind == 'a') return unpack_array(unpacking);
    if (kind == '(') return unpack_tuple(unpacking);
    if (kind == 'E' || kind == 'T') {
        PyObject *class_of_value = PyTuple_GetItem(unpacking->kernel->classes, unpacking->n_classes++);
        PyObject *value = unpack(unpacking), *result = NULL;
        if (value && kind == 'T') result = PyObject_CallObject(class_of_value, value);
        else if (value) result = PyObject_CallFunctionObjArgs(class_of_value, value, NULL);
        if (value) Py_DecRef(value);
        return result;
    }
    int64_t bits;
    memcpy(&bits, unpacking->data, 8);
    unpacking->data += 8;
    if (kind == 'q') return PyLong_FromLongLong(bits);
    double number;
    memcpy(&number, &bits, 8);
    return PyFloat_FromDouble(number);
}

static PyObject *call(PyObject *capsule, PyObject *arguments) {
    const Kernel *kernel = PyCapsule_GetPointer(capsule, "kernel");
    int64_t slots[kernel->n_slots + RESULT_SLOTS];
    Packing packing = {kernel->arguments, slots};
    if (!pack_tuple(&packing, arguments)) return PyObject_CallObject(kernel->fallback, arguments);
    int status = kernel->entry(slots);
    if (status != 0 && status != -2) /* -2: None */
        return PyErr_Format(PyExc_RuntimeError, "kernel %s ended with status %d; GOVERNOR_MECHANISM_JIT=0 shows where", kernel->method.ml_name, status);
    Unpacking unpacking = {kernel->result, (const char *)(slots + kernel->n_slots), 0, kernel};
    return unpack(&unpacking);
}

/* Return a function of Python that calls a kernel; it lives as long as the process. */
__attribute__((visibility("default"))) PyObject *make_caller(const char *name, void *entry, const char *arguments, const char *result, int n_slots, PyObject *classes,
                      PyObject *fallback, PyObject *new_array) {
    Kernel *kernel = malloc(sizeof(Kernel));
    if (!kernel) return PyErr_Format(PyExc_RuntimeError, "no memory for kernel %s", name);
    Py_IncRef(classes);
    Py_IncRef(fallback);
    Py_IncRef(new_array);
    *kernel = (Kernel){(int (*)(int64_t *))(intptr_t)entry, strdup(arguments), strdup(result), classes, fallback, new_array, n_slots,
                       {strdup(name), call, METH_VARARGS, NULL}};
    PyObject *capsule = PyCapsule_New(kernel, "kernel", NULL);
    PyObject *function = capsule ? PyCFunction_NewEx(&kernel->method, capsule, NULL) : NULL;
    if (capsule) Py_DecRef(capsule);
    return function;
}
