/* The part of Python's stable ABI (3.11) that the library uses, declared here: one library serves every later version
   of Python, and no headers of Python are needed to build it. Not for builds of Python without the global lock. */
#ifndef PYTHON_ABI_H
#define PYTHON_ABI_H
#include <stdint.h>

typedef intptr_t Py_ssize_t;
typedef struct _typeobject PyTypeObject;
typedef struct _object {
    Py_ssize_t reference_count;
    PyTypeObject *type;
} PyObject;
typedef struct {
    void *buf;
    PyObject *obj;
    Py_ssize_t len, itemsize;
    int readonly, ndim;
    char *format;
    Py_ssize_t *shape, *strides, *suboffsets;
    void *internal;
} Py_buffer;
typedef PyObject *(*PyCFunction)(PyObject *, PyObject *);
typedef struct {
    const char *ml_name;
    PyCFunction ml_meth;
    int ml_flags;
    const char *ml_doc;
} PyMethodDef;

enum { METH_VARARGS = 1, PyBUF_FORMAT = 0x4, PyBUF_STRIDES = 0x18 };
#define TYPE_IS_LONG (1UL << 24)
#define TYPE_IS_TUPLE (1UL << 26)

#ifdef _WIN32
#define IN_PYTHON __declspec(dllimport) extern
#else
#define IN_PYTHON extern
#endif
IN_PYTHON PyTypeObject PyFloat_Type, PyBool_Type;
IN_PYTHON PyObject _Py_NoneStruct, *PyExc_RuntimeError;

void Py_IncRef(PyObject *);
void Py_DecRef(PyObject *);
unsigned long PyType_GetFlags(PyTypeObject *);
int PyType_IsSubtype(PyTypeObject *, PyTypeObject *);
Py_ssize_t PyTuple_Size(PyObject *);
PyObject *PyTuple_GetItem(PyObject *, Py_ssize_t);
PyObject *PyTuple_New(Py_ssize_t);
int PyTuple_SetItem(PyObject *, Py_ssize_t, PyObject *);
double PyFloat_AsDouble(PyObject *);
PyObject *PyFloat_FromDouble(double);
long long PyLong_AsLongLong(PyObject *);
PyObject *PyLong_FromLongLong(long long);
PyObject *PyBool_FromLong(long);
PyObject *PyUnicode_FromString(const char *);
PyObject *PyByteArray_FromStringAndSize(const char *, Py_ssize_t);
int PyObject_GetBuffer(PyObject *, Py_buffer *, int);
void PyBuffer_Release(Py_buffer *);
int PyBuffer_IsContiguous(const Py_buffer *, char);
PyObject *PyObject_CallObject(PyObject *, PyObject *);
PyObject *PyObject_CallFunctionObjArgs(PyObject *, ...);
PyObject *PyCapsule_New(void *, const char *, void (*)(PyObject *));
void *PyCapsule_GetPointer(PyObject *, const char *);
PyObject *PyCFunction_NewEx(PyMethodDef *, PyObject *, PyObject *);
void PyErr_SetString(PyObject *, const char *);
void PyErr_Clear(void);
PyObject *PyErr_Occurred(void);
PyObject *PyErr_Format(PyObject *, const char *, ...);
#endif
