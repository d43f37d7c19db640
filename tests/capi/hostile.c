/* Calls that must come back with a reason. Prints the line of the first that does not. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "asperity.h"
#include "bsdf_example.h"

#define REFUSED(call, reason) \
  do {                        \
    if ((call) != ASPERITY_STATUS_##reason) return __LINE__; \
  } while (0)

static float endless(void *state) {
  (void)state;
  return NAN;
}

static float half(void *state) {
  (void)state;
  return 0.5f;
}

static int ggx(void) {
  float wi[3] = {0.0f, 0.0f, 1.0f}, bad[3] = {NAN, 0.0f, 1.0f}, zero[3] = {0.0f, 0.0f, 0.0f};
  float flat[3] = {1.0f, 0.0f, 0.0f}, out[2];
  unsigned char bytes[sizeof(asperity_ggx) + 8];
  asperity_ggx law;
  asperity_ray ray;
  memset(&law, 0, sizeof law);
  REFUSED(asperity_ggx_init(NULL, 0.3f, 1.5f, 0), NULL_POINTER);
  REFUSED(asperity_ggx_init((asperity_ggx *)(void *)(bytes + 1 + ((uintptr_t)bytes & 1)), 0.3f, 1.5f, 0), MISALIGNED);
  REFUSED(asperity_ggx_eval(&law, wi, wi, out), NOT_INITIALISED);
  REFUSED(asperity_ggx_init(&law, NAN, 1.5f, 0), NOT_FINITE);
  REFUSED(asperity_ggx_init(&law, 0.3f, 0.0f, 0), OUT_OF_DOMAIN);
  REFUSED(asperity_ggx_init(&law, 0.3f, 1.5f, 77), UNKNOWN_OPTION);
  REFUSED(asperity_ggx_init(&law, 0.3f, 1.5f, ASPERITY_TIER_EXACT), OK);
  REFUSED(asperity_ggx_eval(NULL, wi, wi, out), NULL_POINTER);
  REFUSED(asperity_ggx_eval(&law, NULL, wi, out), NULL_POINTER);
  REFUSED(asperity_ggx_eval(&law, wi, wi, NULL), NULL_POINTER);
  REFUSED(asperity_ggx_eval(&law, (float *)(void *)((char *)wi + 1), wi, out), MISALIGNED);
  REFUSED(asperity_ggx_pdf(&law, bad, wi, out), NOT_FINITE);
  if (!isnan(out[0])) return __LINE__;
  REFUSED(asperity_ggx_ars(&law, wi, zero, out), ZERO_VECTOR);
  REFUSED(asperity_ggx_eval(&law, flat, wi, out), OK);
  if (out[0] != 0.0f) return __LINE__;
  REFUSED(asperity_ggx_batch(&law, 3, 1, wi, 0, wi, 0, out), UNKNOWN_OPTION);
  REFUSED(asperity_ggx_batch(&law, 0, SIZE_MAX, wi, 3, wi, 0, out), OUT_OF_DOMAIN);
  REFUSED(asperity_ggx_batch(&law, 0, 0, NULL, 0, NULL, 0, NULL), OK);
  REFUSED(asperity_ggx_sample(&law, wi, NULL, NULL, &ray), NULL_POINTER);
  REFUSED(asperity_ggx_sample(&law, wi, endless, NULL, &ray), OUT_OF_DOMAIN);
  REFUSED(asperity_ggx_sample(&law, bad, half, NULL, &ray), NOT_FINITE);
  REFUSED(asperity_ggx_sample(&law, wi, half, NULL, NULL), NULL_POINTER);
  return 0;
}

static int normals(void) {
  float wi[3] = {0.0f, 0.0f, 1.0f};
  asperity_normals law;
  asperity_ray ray;
  memset(&law, 0, sizeof law);
  REFUSED(asperity_normals_init(&law, 2, 0.1f, 2.0f, 0.0f, 1.5f, 0), UNKNOWN_OPTION);
  REFUSED(asperity_normals_init(&law, 0, INFINITY, 2.0f, 0.0f, 1.5f, 0), NOT_FINITE);
  REFUSED(asperity_normals_init(&law, 0, 0.1f, 2.0f, 3.0f, 1.5f, 0), OUT_OF_DOMAIN);
  REFUSED(asperity_normals_sample(&law, wi, half, NULL, &ray), NOT_INITIALISED);
  REFUSED(asperity_normals_init(&law, 0, 0.1f, 2.0f, 0.0f, 1.5f, 0), OK);
  /* numbers that never end a search end it after all */
  REFUSED(asperity_normals_sample(&law, wi, endless, NULL, &ray), OUT_OF_DOMAIN);
  /* of another kind */
  REFUSED(asperity_ggx_sample((asperity_ggx *)(void *)&law, wi, half, NULL, &ray), NOT_INITIALISED);
  return 0;
}

static int table(void) {
  const float nan = NAN, negative = -1.0f;
  float wi[3] = {0.0f, 0.0f, 1.0f}, out;
  static const asperity_table_source good = ASPERITY_TABLE_SOURCE(bsdf_example);
  asperity_table_source bad;
  asperity_table law;
  uint16_t lobes[4][6];
  uint16_t *copy;
  float gains[sizeof bsdf_example_gains / sizeof bsdf_example_gains[0]];
  uint32_t sum;
  size_t k;
  memset(&law, 0, sizeof law);
  REFUSED(asperity_table_init(&law, NULL, 0), NULL_POINTER);
  bad = good, bad.lobes = NULL;
  REFUSED(asperity_table_init(&law, &bad, 0), NULL_POINTER);
  bad = good, bad.values = NULL;
  REFUSED(asperity_table_init(&law, &bad, 0), NULL_POINTER);
  bad = good, bad.values = (const char *)good.values + 1;
  REFUSED(asperity_table_init(&law, &bad, 0), MISALIGNED);
  bad = good, bad.values_length -= 1;
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_LENGTH);
  REFUSED(asperity_table_init_trusted(&law, &bad, 0), TABLE_LENGTH);
  bad = good, bad.fluxes_length = 0;
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_LENGTH);
  bad = good, bad.value_bytes = 8;
  REFUSED(asperity_table_init(&law, &bad, 0), UNKNOWN_OPTION);
  bad = good, bad.eta = NULL;
  REFUSED(asperity_table_init(&law, &bad, 0), NULL_POINTER);
  bad = good, bad.eta = &nan;
  REFUSED(asperity_table_init(&law, &bad, 0), NOT_FINITE);
  bad = good, bad.slope = &negative;
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_NUMBER);
  memcpy(lobes, bsdf_example_lobes, sizeof lobes);
  lobes[1][0] = lobes[1][1] = lobes[1][2] = lobes[1][3] = 0xffff;
  bad = good, bad.lobes = &lobes[0][0];
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_SHAPE);
  REFUSED(asperity_table_eval(&law, wi, wi, &out), NOT_INITIALISED);
  /* truncated arrays in memory of their own length, so that Valgrind sees a step too far */
  copy = malloc(good.values_length * sizeof *copy);
  if (copy == NULL) return __LINE__;
  memcpy(copy, good.values, good.values_length * sizeof *copy);
  bad = good, bad.values = copy;
  for (k = 0; k < good.values_length; ++k) {
    bad.values_length = k;
    REFUSED(asperity_table_init(&law, &bad, 0), TABLE_LENGTH);
    REFUSED(asperity_table_init_payload(&law, &good, copy, k, 0), TABLE_LENGTH);
  }
  REFUSED(asperity_table_init_payload(&law, &good, (char *)copy + 2, 4, 0), MISALIGNED);
  REFUSED(asperity_table_init_payload(&law, &good, NULL, 4, 0), NULL_POINTER);
  free(copy);
  /* a bit of an array, of a number, of the sum; and gains out of any domain without a sum */
  memcpy(gains, bsdf_example_gains, sizeof gains);
  for (k = 0; k < 32; ++k) {
    ((unsigned char *)gains)[k % 4 + 40] ^= (unsigned char)(1u << k / 4);
    bad = good, bad.gains = gains;
    if (asperity_table_init(&law, &bad, 0) == ASPERITY_STATUS_OK) return __LINE__;
    REFUSED(asperity_table_eval(&law, wi, wi, &out), NOT_INITIALISED);
    ((unsigned char *)gains)[k % 4 + 40] ^= (unsigned char)(1u << k / 4);
    sum = bsdf_example_checksum ^ (UINT32_C(1) << k);
    bad = good, bad.checksum = &sum;
    REFUSED(asperity_table_init(&law, &bad, 0), TABLE_CHECKSUM);
  }
  bad = good, bad.checksum = NULL;
  REFUSED(asperity_table_init(&law, &bad, 0), OK);
  gains[3] *= 1e6f;
  bad.gains = gains;
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_ENERGY);
  gains[3] = 1e20f;
  REFUSED(asperity_table_init(&law, &bad, 0), TABLE_NUMBER);
  REFUSED(asperity_table_init(&law, &good, 0), OK);
  REFUSED(asperity_table_reflectance(&law, 2.0f, 0, &out), OUT_OF_DOMAIN);
  REFUSED(asperity_table_reflectance(&law, NAN, 0, &out), NOT_FINITE);
  REFUSED(asperity_table_reflectance(&law, 1.0f, 9, &out), UNKNOWN_OPTION);
  return 0;
}

int main(void) {
  int line = ggx();
  if (line == 0) line = normals();
  if (line == 0) line = table();
  if (asperity_status_text(-5) == NULL || asperity_version()[0] == '\0') line = __LINE__;
  if (line != 0) printf("line %d\n", line);
  return line == 0 ? 0 : 1;
}
