/* Values, densities, rays and fluxes of a law of each kind, printed as hexadecimal floats.

   cc -std=c99 -I ../include evaluate.c -o evaluate ../../../target/release/libasperity_capi.a -lm -lpthread -ldl */
#include <stdio.h>
#include <string.h>

#include "asperity.h"
#include "bsdf_example.h" /* made by `asperity tabulate --c` */

#define PAIRS 4

static const float WI[3] = {0.6f, 0.0f, 0.8f};
static const float WO[PAIRS][3] = {
    {-0.4f, 0.0f, -0.9f}, {-0.5f, 0.1f, 0.7f}, {0.1f, -0.3f, -1.0f}, {0.2f, 0.2f, 0.0f}};

static int failures = 0;

/* Says what a call came to unless it is what it should. */
static void expect(const char *what, asperity_status status, asperity_status wanted) {
  if (status != wanted) {
    printf("%s: %s\n", what, asperity_status_text(status));
    failures += 1;
  }
}

static void ok(const char *what, asperity_status status) { expect(what, status, ASPERITY_STATUS_OK); }

/* A linear congruential generator; any source of numbers in [0, 1) will do. */
static float uniform(void *state) {
  uint32_t *word = (uint32_t *)state;
  *word = *word * UINT32_C(1664525) + UINT32_C(1013904223);
  return (float)(*word >> 8) / 16777216.0f;
}

static void print_values(const char *law, const char *what, const float values[PAIRS]) {
  int k;
  for (k = 0; k < PAIRS; ++k) printf("%s %s %a\n", law, what, (double)values[k]);
}

static void print_rays(const char *law, const asperity_ray *rays, int count) {
  int k;
  for (k = 0; k < count; ++k)
    printf("%s ray %a %a %a %a\n", law, (double)rays[k].wo[0], (double)rays[k].wo[1],
           (double)rays[k].wo[2], (double)rays[k].weight);
}

static void ggx(void) {
  asperity_ggx law;
  asperity_ray rays[PAIRS];
  float values[PAIRS];
  uint32_t seed = 1;
  int k;
  ok("init", asperity_ggx_init(&law, 0.25f, 1.49f, ASPERITY_TIER_FAST));
  for (k = 0; k < PAIRS; ++k) ok("eval", asperity_ggx_eval(&law, WI, WO[k], &values[k]));
  print_values("ggx", "eval", values);
  for (k = 0; k < PAIRS; ++k) ok("ars", asperity_ggx_ars(&law, WI, WO[k], &values[k]));
  print_values("ggx", "ars", values);
  for (k = 0; k < PAIRS; ++k) ok("pdf", asperity_ggx_pdf(&law, WI, WO[k], &values[k]));
  print_values("ggx", "pdf", values);
  for (k = 0; k < PAIRS; ++k) ok("sample", asperity_ggx_sample(&law, WI, uniform, &seed, &rays[k]));
  print_rays("ggx", rays, PAIRS);
}

static void normals(void) {
  asperity_normals law;
  asperity_ray rays[PAIRS];
  float values[PAIRS];
  uint32_t seed = 1;
  ok("init", asperity_normals_init(&law, ASPERITY_PROFILE_GAUSS, 0.12f, 1.66f, 0.0f, 1.49f, ASPERITY_TIER_EXACT));
  ok("batch", asperity_normals_batch(&law, ASPERITY_QUANTITY_EVAL, PAIRS, WI, 0, WO[0], 3, values));
  print_values("normals", "eval", values);
  ok("init", asperity_normals_init(&law, ASPERITY_PROFILE_GAUSS, 0.12f, 1.66f, 0.0f, 1.49f, ASPERITY_TIER_FAST));
  ok("batch", asperity_normals_batch(&law, ASPERITY_QUANTITY_PDF, PAIRS, WI, 0, WO[0], 3, values));
  print_values("normals", "pdf", values);
  ok("rays", asperity_normals_sample_batch(&law, PAIRS, WI, uniform, &seed, rays));
  print_rays("normals", rays, PAIRS);
}

static void table(void) {
  static const asperity_table_source source = ASPERITY_TABLE_SOURCE(bsdf_example);
  asperity_table law;
  asperity_ray rays[PAIRS];
  float values[PAIRS];
  uint32_t seed = 1;
  int k;
  ok("init", asperity_table_init(&law, &source, ASPERITY_TIER_FAST));
  ok("batch", asperity_table_batch(&law, ASPERITY_QUANTITY_EVAL, PAIRS, WI, 0, WO[0], 3, values));
  print_values("table", "eval", values);
  for (k = 0; k < PAIRS; ++k) ok("pdf", asperity_table_pdf(&law, WI, WO[k], &values[k]));
  print_values("table", "pdf", values);
  ok("rays", asperity_table_sample_batch(&law, PAIRS, WI, uniform, &seed, rays));
  print_rays("table", rays, PAIRS);
  ok("reflectance", asperity_table_reflectance(&law, 0.8f, ASPERITY_SIDE_AIR, &values[0]));
  ok("transmittance", asperity_table_transmittance(&law, 0.8f, ASPERITY_SIDE_AIR, &values[1]));
  printf("table reflectance %a\ntable transmittance %a\n", (double)values[0], (double)values[1]);
}

/* What is wrong comes back as a status. */
static void refusals(void) {
  asperity_ggx law;
  float nowhere[3] = {0.0f, 0.0f, 0.0f};
  float value = 0.0f;
  memset(&law, 0, sizeof law);
  expect("no init", asperity_ggx_eval(&law, WI, WO[0], &value), ASPERITY_STATUS_NOT_INITIALISED);
  expect("alpha", asperity_ggx_init(&law, -1.0f, 1.49f, ASPERITY_TIER_FAST), ASPERITY_STATUS_OUT_OF_DOMAIN);
  ok("init", asperity_ggx_init(&law, 0.25f, 1.49f, ASPERITY_TIER_FAST));
  expect("zero", asperity_ggx_eval(&law, nowhere, WO[0], &value), ASPERITY_STATUS_ZERO_VECTOR);
  expect("null", asperity_ggx_eval(&law, NULL, WO[0], &value), ASPERITY_STATUS_NULL_POINTER);
}

int main(void) {
  ggx();
  normals();
  table();
  refusals();
  return failures == 0 ? 0 : 1;
}
