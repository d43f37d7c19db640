/* The least firmware that evaluates a table. */
#include "asperity.h"
#include "bsdf_example.h"

volatile float from_sensor[6];
volatile float to_motor;

void reset(void) {
  static const asperity_table_source source = ASPERITY_TABLE_SOURCE(bsdf_example);
  asperity_table law;
  if (asperity_table_init_trusted(&law, &source, ASPERITY_TIER_FAST) == ASPERITY_STATUS_OK)
    for (;;) {
      float wi[3] = {from_sensor[0], from_sensor[1], from_sensor[2]};
      float wo[3] = {from_sensor[3], from_sensor[4], from_sensor[5]};
      float value;
      if (asperity_table_eval(&law, wi, wo, &value) == ASPERITY_STATUS_OK) to_motor = value;
    }
  for (;;) {
  }
}

/* Where a Cortex-M finds its stack and its first instruction. */
struct vectors {
  uint32_t stack;
  void (*reset)(void);
};

__attribute__((section(".vectors"), used)) const struct vectors vectors = {0x20004000, reset};
