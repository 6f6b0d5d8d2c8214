/* Quoin contact-law ABI: versions, status codes and text buffers.
 * C99 and C++11 or later; no dependency but <stdint.h>.
 *
 * Rules for every header of this folder (a change that breaks one is a new major version):
 *   - Every struct that crosses the boundary begins with its size in bytes, which its allocator sets. New fields are
 *     appended, and a reader accesses no field beyond that size. The column types of batch.h have no size: they are
 *     embedded by value and do not change within a major version.
 *   - A struct that is shorter than in version 1.0 is refused: QUOIN_ERROR_ARGUMENT, or null from quoin_library_v1.
 *     A quoin_text that is too short counts as null.
 *   - Layouts have only fixed-width integers, doubles and pointers: no enum, bool, long, bit-field or C++ type.
 *   - No exception, longjmp, signal, stdio or change of floating-point mode crosses the boundary.
 *   - Units are SI (m, Pa, Pa/m, J/m2); degrees only for properties with the unit "deg".
 * Tag on functions: [thread-safe] may be called from any thread at any time. */
#ifndef QUOIN_BASE_H
#define QUOIN_BASE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A new major version changes layouts or meanings; a new minor version appends fields or constants. A host and a law
 * work together if their majors are equal; both then use only the features of the smaller minor. */
#define QUOIN_ABI_MAJOR 1u
#define QUOIN_ABI_MINOR 1u

#if defined(_WIN32)
#define QUOIN_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define QUOIN_EXPORT __attribute__((visibility("default")))
#else
#define QUOIN_EXPORT
#endif

typedef int32_t quoin_status;
#define QUOIN_OK ((quoin_status)0)
#define QUOIN_ERROR_ARGUMENT ((quoin_status)1)    /* the call breaks the contract: null, short struct, stride */
#define QUOIN_ERROR_PROPERTY ((quoin_status)2)    /* property values are refused; the text lists every fault */
#define QUOIN_ERROR_VERSION ((quoin_status)3)     /* no common ABI version, or another state schema */
#define QUOIN_ERROR_UNSUPPORTED ((quoin_status)4) /* the law does not offer the request */
#define QUOIN_ERROR_MEMORY ((quoin_status)5)
#define QUOIN_ERROR_INTERNAL ((quoin_status)6) /* a fault inside the law, caught at the boundary */

/* Text buffer of the caller. A law writes at most capacity bytes including the final zero and truncates a longer
 * message. It sets length to the size of the whole message in bytes, without the zero. A null quoin_text, or null data
 * with capacity 0, is allowed everywhere and means that the caller requests no text. In the second case length is still
 * set. Without a message length is 0 and, if capacity > 0, data[0] = 0. */
typedef struct quoin_text {
  uint64_t struct_size;
  char* data;
  uint64_t capacity;
  uint64_t length;
} quoin_text;

#ifdef __cplusplus
}
#endif
#endif
