// Reads files of Asperity with the readers of libbsdf and prints what it finds: run by hand.
//
//   cmake -S libbsdf -B build -DLIBBSDF_BUILD_APPLICATIONS=OFF && make -C build
//   g++ -std=c++17 -fopenmp -I libbsdf/include -I /usr/include/eigen3 tests/peers/libbsdf.cpp build/liblibbsdf.a -o peer
//   peer FILE CSV [INDEX]
//
// FILE is .bsdf (Zemax), .ssdd, .ddr, .ddt or .astm; CSV is the same lobe as `asperity export --format csv` writes it, of the same grid or another
// one: theta_i,phi_i,theta_o,phi_o,f in degrees about the sample. A line for each incidence of the CSV: the flux that libbsdf finds, and
// the largest difference of its values from those of the CSV in percent of the largest. INDEX is for a BTDF of Zemax: libbsdf takes the angle of the
// direct ray, which such a file gives, for that of the incidence, and is asked for that one.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <libbsdf/Brdf/Analyzer.h>
#include <libbsdf/Brdf/Bsdf.h>
#include <libbsdf/Common/Log.h>
#include <libbsdf/Reader/AstmReader.h>
#include <libbsdf/Reader/ReaderUtility.h>

namespace {

struct Row {
    double theta_o, phi_o, f;
};

const double kRadian = std::acos(-1.0) / 180.0;

// Directions as libbsdf has them: the source over the surface, and the mirrored half space for transmission.
lb::Vec3 direction(double theta, double phi) {
    const double t = theta > 90.0 ? 180.0 - theta : theta;
    return lb::SphericalCoordinateSystem::toXyz(t * kRadian, phi * kRadian);
}

std::map<std::pair<double, double>, std::vector<Row>> readCsv(const char* path) {
    std::map<std::pair<double, double>, std::vector<Row>> rows;
    std::ifstream file(path);
    std::string line;
    while (std::getline(file, line)) {
        for (char& c : line) c = c == ',' ? ' ' : c;
        std::istringstream fields(line);
        double theta_i, phi_i;
        Row row;
        if (fields >> theta_i >> phi_i >> row.theta_o >> row.phi_o >> row.f) {
            rows[{theta_i, phi_i}].push_back(row);
        }
    }
    return rows;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "peer FILE CSV [INDEX]\n");
        return 2;
    }
    const double index = argc > 3 ? std::atof(argv[3]) : 1.0;
    lb::Log::setNotificationLevel(lb::Log::Level::WARN_MSG);
    lb::FileType fileType;
    lb::DataType dataType = lb::UNKNOWN_DATA;
    std::shared_ptr<lb::Brdf> brdf = lb::reader_utility::readBrdf(argv[1], &fileType, &dataType);
    if (!brdf) {
        std::fprintf(stderr, "%s: libbsdf does not read it\n", argv[1]);
        return 1;
    }
    std::printf("%s: %s\n", argv[1], dataType == lb::BTDF_DATA ? "BTDF" : dataType == lb::BRDF_DATA ? "BRDF" : "unknown");
    for (const auto& [incidence, rows] : readCsv(argv[2])) {
        const double sine = std::sin(incidence.first * kRadian) / index;
        const lb::Vec3 in = direction(std::asin(sine) / kRadian, incidence.second);
        double peak = 0.0, worst = 0.0;
        Row at{};
        for (const Row& row : rows) peak = std::max(peak, row.f);
        for (const Row& row : rows) {
            const double t = row.theta_o > 90.0 ? 180.0 - row.theta_o : row.theta_o;
            if (t > 89.99) continue;
            const double is = brdf->getSpectrum(in, direction(row.theta_o, row.phi_o))[0];
            if (std::abs(is - row.f) > worst) {
                worst = std::abs(is - row.f);
                at = row;
            }
        }
        const double flux = lb::computeReflectance(*brdf, in)[0];
        std::printf("incidence %g: %zu directions, flux %.6f, difference %.3e %% of the peak %.6g (at %g %g: %g)\n", incidence.first,
                    rows.size(), flux, 100.0 * worst / peak, peak, at.theta_o, at.phi_o, at.f);
    }
    return 0;
}
