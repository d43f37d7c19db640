/* The evaluators of Asperity for C99 and C++11. Generated from host/capi; do not edit.

   Frame: +z is the mean surface normal and points into the air. Directions are float[3] of any length,
   pointing away from the surface: wi to where light comes from, wo to where it goes; z > 0 is the air.
   Flux, not radiance, is transported: there is no factor eta^2 (CONVENTIONS.md).

   Objects live in storage of the caller, may be copied, and are only read by all functions but `init`: any
   number of threads may share one. Nothing is allocated, and there is nothing to free.

   Every function that can fail returns an `asperity_status`. Null and misaligned pointers are found, and
   objects without a successful `init` where their memory does not say otherwise by chance (zero it). A
   pointer that passes must point to as much memory as the function says, which nothing else writes
   meanwhile. A direction that is NaN, infinite or zero gives the reason, and NaN as a value; one in the
   surface (z = 0) gives 0, or a lost ray. After another error values are as they were, and an object that
   was to be made is none. */

#ifndef ASPERITY_H
#define ASPERITY_H

#include <stddef.h>
#include <stdint.h>

/*
 What a call came to; 0 is success.
 */
enum asperity_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   All is well.
   */
  ASPERITY_STATUS_OK = 0,
  /*
   A pointer that must not be null is.
   */
  ASPERITY_STATUS_NULL_POINTER = 1,
  /*
   A pointer is not aligned to what it points to.
   */
  ASPERITY_STATUS_MISALIGNED = 2,
  /*
   The object was never initialised, or not with success, or is of another kind.
   */
  ASPERITY_STATUS_NOT_INITIALISED = 3,
  /*
   A number is NaN or infinite.
   */
  ASPERITY_STATUS_NOT_FINITE = 4,
  /*
   A direction has no length.
   */
  ASPERITY_STATUS_ZERO_VECTOR = 5,
  /*
   A number is outside its domain.
   */
  ASPERITY_STATUS_OUT_OF_DOMAIN = 6,
  /*
   An option has no such value, or this library was built without it.
   */
  ASPERITY_STATUS_UNKNOWN_OPTION = 7,
  /*
   An axis of a table has fewer than two nodes, or more than a table can have.
   */
  ASPERITY_STATUS_TABLE_SHAPE = 8,
  /*
   An array of a table, or its payload, has another length than its axes ask for.
   */
  ASPERITY_STATUS_TABLE_LENGTH = 9,
  /*
   A number of a table is outside its domain.
   */
  ASPERITY_STATUS_TABLE_NUMBER = 10,
  /*
   Quantiles of a table do not ascend from 0, or a lean is beyond 125/128.
   */
  ASPERITY_STATUS_TABLE_QUANTILES = 11,
  /*
   A table reflects and transmits more light than there is.
   */
  ASPERITY_STATUS_TABLE_ENERGY = 12,
  /*
   The checksum of a table is another: a bit of its numbers or arrays is not what it was.
   */
  ASPERITY_STATUS_TABLE_CHECKSUM = 13,
  /*
   A table of an opaque body that does more than reflect light from the air.
   */
  ASPERITY_STATUS_TABLE_OPAQUE = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum asperity_status asperity_status;
#else
typedef int32_t asperity_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 How elementary functions are computed; everything else has the same bits in both.
 */
enum asperity_tier
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   By short polynomials, good to a few units of the last place.
   */
  ASPERITY_TIER_FAST = 0,
  /*
   As the program `asperity` computes them; slower.
   */
  ASPERITY_TIER_EXACT = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum asperity_tier asperity_tier;
#else
typedef uint32_t asperity_tier;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 The shape of a law of facet angles.
 */
enum asperity_profile
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   `exp(-|t - t0|^n / (2 delta^n))`
   */
  ASPERITY_PROFILE_GAUSS = 0,
  /*
   `delta^n / (|t - t0|^n + delta^n)`
   */
  ASPERITY_PROFILE_CAUCHY = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum asperity_profile asperity_profile;
#else
typedef uint32_t asperity_profile;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 What a batch computes.
 */
enum asperity_quantity
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   The BSDF in 1/sr, without cosine.
   */
  ASPERITY_QUANTITY_EVAL = 0,
  /*
   The BSDF times the cosine of `wo`: scattered flux per solid angle, for unit flux in.
   */
  ASPERITY_QUANTITY_ARS = 1,
  /*
   Density of the samples at `wo`, per solid angle.
   */
  ASPERITY_QUANTITY_PDF = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum asperity_quantity asperity_quantity;
#else
typedef uint32_t asperity_quantity;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 The side light comes from.
 */
enum asperity_side
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   z > 0.
   */
  ASPERITY_SIDE_AIR = 0,
  /*
   z < 0.
   */
  ASPERITY_SIDE_DIELECTRIC = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum asperity_side asperity_side;
#else
typedef uint32_t asperity_side;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 A rough dielectric of GGX facets. Opaque: only functions of this library look inside; it may be copied.
 */
typedef struct asperity_ggx {
  /*
   Room for it.
   */
  uint32_t opaque[16];
} asperity_ggx;

/*
 A source of uniform numbers in [0, 1); it must return, and must not throw. `state` is what the caller gave.
 */
typedef float (*asperity_uniform)(void *state);

/*
 A scattered ray.
 */
typedef struct asperity_ray {
  /*
   Direction, away from the surface, on either side; zeros for a lost ray.
   */
  float wo[3];
  /*
   Flux it carries away for unit flux in; 0 for a lost ray.
   */
  float weight;
} asperity_ray;

/*
 A rough dielectric whose facets are drawn from a law of angles. Opaque: only functions of this library look inside; it may be copied.
 */
typedef struct asperity_normals {
  /*
   Room for it.
   */
  uint32_t opaque[512];
} asperity_normals;

/*
 A table made by `asperity tabulate`, in arrays of the caller. Opaque: only functions of this library look inside; it may be copied.
 */
typedef struct asperity_table {
  /*
   Room for it.
   */
  size_t opaque[104];
} asperity_table;

/*
 The numbers and arrays of a table: those of the C header that `asperity tabulate --c` writes, under the same names.
 `ASPERITY_TABLE_SOURCE` fills it. Lengths count numbers, not bytes. A missing array is null, of length 0.
 */
typedef struct asperity_table_source {
  /*
   Index of the dielectric over that of air; of an opaque body a number of the format, and no index of anything.
   */
  const float *eta;
  /*
   Typical slope of the facets.
   */
  const float *slope;
  /*
   4 rows of 6: incidences, azimuths, radii, intervals, form, fall; zeros for a lobe left out.
   */
  const uint16_t *lobes;
  /*
   4 rows of 3: scale of slopes, crowding of incidences, width of masking.
   */
  const float *scales;
  /*
   Incidences of the fluxes from the air and from the dielectric.
   */
  const uint16_t *flux_incidences;
  /*
   Crowding of these.
   */
  const float *flux_grazing;
  /*
   One an incidence of a lobe.
   */
  const float *gains;
  /*
   Of `value_bytes` each.
   */
  const void *values;
  /*
   Of the samples.
   */
  const uint16_t *quantiles;
  /*
   Of the samples.
   */
  const int8_t *leans;
  /*
   Four an incidence of the fluxes.
   */
  const uint16_t *fluxes;
  /*
   CRC-32C of all the numbers and arrays; null for a table without one, whose damage goes unseen.
   */
  const uint32_t *checksum;
  /*
   Length of `gains`.
   */
  size_t gains_length;
  /*
   Length of `values`.
   */
  size_t values_length;
  /*
   Length of `quantiles`.
   */
  size_t quantiles_length;
  /*
   Length of `leans`.
   */
  size_t leans_length;
  /*
   Length of `fluxes`.
   */
  size_t fluxes_length;
  /*
   Bytes of a value: 1 and 2 are unsigned integers, 4 is `float`.
   */
  uint32_t value_bytes;
  /*
   1 for an opaque body, which reflects light from the air and does nothing else; 0 for a dielectric.
   */
  uint32_t opaque;
} asperity_table_source;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 `alpha` is the width of the slopes, 1e-6 to 100; `eta` the index of the dielectric over that of air, 0.1 to 10;
 `tier` an `asperity_tier`.
 */
asperity_status asperity_ggx_init(struct asperity_ggx *ggx,
                                  float alpha,
                                  float eta,
                                  uint32_t tier);

/*
 The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
 */
asperity_status asperity_ggx_eval(const struct asperity_ggx *ggx,
                                  const float *wi,
                                  const float *wo,
                                  float *out);

/*
 Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
 */
asperity_status asperity_ggx_ars(const struct asperity_ggx *ggx,
                                 const float *wi,
                                 const float *wo,
                                 float *out);

/*
 Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
 */
asperity_status asperity_ggx_pdf(const struct asperity_ggx *ggx,
                                 const float *wi,
                                 const float *wo,
                                 float *out);

/*
 Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
 */
asperity_status asperity_ggx_sample(const struct asperity_ggx *ggx,
                                    const float *wi,
                                    asperity_uniform uniform,
                                    void *state,
                                    struct asperity_ray *ray);

/*
 An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
 direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
 first; the others are computed.
 */
asperity_status asperity_ggx_batch(const struct asperity_ggx *ggx,
                                   uint32_t quantity,
                                   size_t count,
                                   const float *wi,
                                   size_t wi_stride,
                                   const float *wo,
                                   size_t wo_stride,
                                   float *out);

/*
 Draws `count` rays for light from one `wi`, to `count` rays in a row.
 */
asperity_status asperity_ggx_sample_batch(const struct asperity_ggx *ggx,
                                          size_t count,
                                          const float *wi,
                                          asperity_uniform uniform,
                                          void *state,
                                          struct asperity_ray *rays);

/*
 `profile` is an `asperity_profile` of width `delta` (1e-6 to 10, radians), exponent `n` (0.1 to 100) and centre
 `theta0` (0 to pi/2); `eta` is the index of the dielectric over that of air, 0.1 to 10; `tier` an `asperity_tier`.
 Integrates in double precision, with a few KiB of stack.
 */
asperity_status asperity_normals_init(struct asperity_normals *normals,
                                      uint32_t profile,
                                      float delta,
                                      float n,
                                      float theta0,
                                      float eta,
                                      uint32_t tier);

/*
 The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
 */
asperity_status asperity_normals_eval(const struct asperity_normals *normals,
                                      const float *wi,
                                      const float *wo,
                                      float *out);

/*
 Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
 */
asperity_status asperity_normals_ars(const struct asperity_normals *normals,
                                     const float *wi,
                                     const float *wo,
                                     float *out);

/*
 Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
 */
asperity_status asperity_normals_pdf(const struct asperity_normals *normals,
                                     const float *wi,
                                     const float *wo,
                                     float *out);

/*
 Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
 */
asperity_status asperity_normals_sample(const struct asperity_normals *normals,
                                        const float *wi,
                                        asperity_uniform uniform,
                                        void *state,
                                        struct asperity_ray *ray);

/*
 An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
 direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
 first; the others are computed.
 */
asperity_status asperity_normals_batch(const struct asperity_normals *normals,
                                       uint32_t quantity,
                                       size_t count,
                                       const float *wi,
                                       size_t wi_stride,
                                       const float *wo,
                                       size_t wo_stride,
                                       float *out);

/*
 Draws `count` rays for light from one `wi`, to `count` rays in a row.
 */
asperity_status asperity_normals_sample_batch(const struct asperity_normals *normals,
                                              size_t count,
                                              const float *wi,
                                              asperity_uniform uniform,
                                              void *state,
                                              struct asperity_ray *rays);

/*
 Checks the arrays of `source`, and their checksum, and views them: they must outlive the object and its copies. `tier` is an
 `asperity_tier`.
 */
asperity_status asperity_table_init(struct asperity_table *table,
                                    const struct asperity_table_source *source,
                                    uint32_t tier);

/*
 The BSDF in 1/sr, without cosine. `wi` and `wo` are three floats each.
 */
asperity_status asperity_table_eval(const struct asperity_table *table,
                                    const float *wi,
                                    const float *wo,
                                    float *out);

/*
 Scattered flux per solid angle for unit flux in: the BSDF times the cosine of `wo`. `wi` and `wo` are three floats each.
 */
asperity_status asperity_table_ars(const struct asperity_table *table,
                                   const float *wi,
                                   const float *wo,
                                   float *out);

/*
 Density of `sample` at `wo`, per solid angle. `wi` and `wo` are three floats each.
 */
asperity_status asperity_table_pdf(const struct asperity_table *table,
                                   const float *wi,
                                   const float *wo,
                                   float *out);

/*
 Draws a ray for light from `wi`, with uniform numbers of the caller. A lost ray has weight 0.
 */
asperity_status asperity_table_sample(const struct asperity_table *table,
                                      const float *wi,
                                      asperity_uniform uniform,
                                      void *state,
                                      struct asperity_ray *ray);

/*
 An `asperity_quantity` for `count` pairs of directions, to `count` floats in a row. Strides are in floats from one
 direction to the next: 3 for vectors in a row, 0 for one vector for all. A bad pair gives NaN, and the status of the
 first; the others are computed.
 */
asperity_status asperity_table_batch(const struct asperity_table *table,
                                     uint32_t quantity,
                                     size_t count,
                                     const float *wi,
                                     size_t wi_stride,
                                     const float *wo,
                                     size_t wo_stride,
                                     float *out);

/*
 Draws `count` rays for light from one `wi`, to `count` rays in a row.
 */
asperity_status asperity_table_sample_batch(const struct asperity_table *table,
                                            size_t count,
                                            const float *wi,
                                            asperity_uniform uniform,
                                            void *state,
                                            struct asperity_ray *rays);

/*
 The same without a look at the numbers in the arrays and at the checksum, for a table that `asperity_table_init` has taken elsewhere, such as
 in the tests of a firmware: it spares flash and start-up time. Lengths are checked; other numbers than those that
 were taken give wrong values, and nothing worse.
 */
asperity_status asperity_table_init_trusted(struct asperity_table *table,
                                            const struct asperity_table_source *source,
                                            uint32_t tier);

/*
 The same of a payload: what follows the first line of a `.bsdft` file. Of `source` the arrays and their lengths are
 not looked at. The payload, and each array in it, must be aligned to its numbers (8-bit values may be followed by a
 misaligned array: `ASPERITY_STATUS_MISALIGNED`; then give copies to `asperity_table_init`). For little-endian
 machines.
 */
asperity_status asperity_table_init_payload(struct asperity_table *table,
                                            const struct asperity_table_source *source,
                                            const void *payload,
                                            size_t bytes,
                                            uint32_t tier);

/*
 1 for the table of an opaque body, which has no index and no inside; 0 for that of a dielectric.
 */
asperity_status asperity_table_is_opaque(const struct asperity_table *table, uint32_t *out);

/*
 Diffusely reflected fraction of the flux at a cosine of incidence, from an `asperity_side`.
 */
asperity_status asperity_table_reflectance(const struct asperity_table *table,
                                           float cosine,
                                           uint32_t side,
                                           float *out);

/*
 Diffusely transmitted fraction of the flux.
 */
asperity_status asperity_table_transmittance(const struct asperity_table *table,
                                             float cosine,
                                             uint32_t side,
                                             float *out);

/*
 Version of the library, as text.
 */
const char *asperity_version(void);

/*
 One line of English for a status, also for a number that is none.
 */
const char *asperity_status_text(int32_t status);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ASPERITY_H */

/* An `asperity_table_source` of the arrays in a header made by `asperity tabulate --c`; `name` is the prefix
   of its names, such as bsdf_example. Make it `static const`: then nothing is copied at start-up. */
#define ASPERITY_TABLE_SOURCE(name)                                                                 \
  { &name##_eta, &name##_slope, &name##_lobes[0][0], &name##_scales[0][0],                            \
    name##_flux_incidences, name##_flux_grazing, name##_gains, name##_values, name##_quantiles,     \
    name##_leans, name##_fluxes, &name##_checksum,                                                  \
    sizeof name##_gains / sizeof name##_gains[0], sizeof name##_values / sizeof name##_values[0],   \
    sizeof name##_quantiles / sizeof name##_quantiles[0],                                           \
    sizeof name##_leans / sizeof name##_leans[0], sizeof name##_fluxes / sizeof name##_fluxes[0],   \
    (uint32_t)sizeof name##_values[0], name##_opaque }
