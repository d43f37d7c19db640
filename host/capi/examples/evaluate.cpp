// The same evaluators from C++: a law as a class whose failures are exceptions.
//
// c++ -std=c++11 -I ../include evaluate.cpp -o evaluate ../../../target/release/libasperity_capi.a -lm -lpthread -ldl
#include <array>
#include <cstdio>
#include <stdexcept>

#include "asperity.h"
#include "bsdf_example.h"  // made by `asperity tabulate --c`

namespace {

typedef std::array<float, 3> Direction;

void check(asperity_status status) {
  if (status != ASPERITY_STATUS_OK) throw std::runtime_error(asperity_status_text(status));
}

class Ggx {
 public:
  Ggx(float alpha, float eta) { check(asperity_ggx_init(&law_, alpha, eta, ASPERITY_TIER_FAST)); }

  float operator()(const Direction &wi, const Direction &wo) const {
    float value;
    check(asperity_ggx_eval(&law_, wi.data(), wo.data(), &value));
    return value;
  }

 private:
  asperity_ggx law_;
};

class Normals {
 public:
  Normals(float delta, float n, float eta) {
    check(asperity_normals_init(&law_, ASPERITY_PROFILE_CAUCHY, delta, n, 0.0f, eta, ASPERITY_TIER_FAST));
  }

  float operator()(const Direction &wi, const Direction &wo) const {
    float value;
    check(asperity_normals_eval(&law_, wi.data(), wo.data(), &value));
    return value;
  }

 private:
  asperity_normals law_;
};

class Table {
 public:
  explicit Table(const asperity_table_source &source) {
    check(asperity_table_init(&law_, &source, ASPERITY_TIER_FAST));
  }

  float operator()(const Direction &wi, const Direction &wo) const {
    float value;
    check(asperity_table_eval(&law_, wi.data(), wo.data(), &value));
    return value;
  }

 private:
  asperity_table law_;
};

}  // namespace

int main() {
  const Direction wi = {{0.6f, 0.0f, 0.8f}}, wo = {{-0.4f, 0.0f, -0.9f}};
  try {
    static const asperity_table_source source = ASPERITY_TABLE_SOURCE(bsdf_example);
    std::printf("ggx %a\n", static_cast<double>(Ggx(0.25f, 1.49f)(wi, wo)));
    std::printf("normals %a\n", static_cast<double>(Normals(0.12f, 2.5f, 1.49f)(wi, wo)));
    std::printf("table %a\n", static_cast<double>(Table(source)(wi, wo)));
  } catch (const std::exception &error) {
    std::printf("%s\n", error.what());
    return 1;
  }
  try {
    Ggx(-1.0f, 1.49f);
  } catch (const std::runtime_error &error) {
    std::printf("refused: %s\n", error.what());
    return 0;
  }
  return 1;
}
