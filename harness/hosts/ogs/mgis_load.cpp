// Loads behaviours by MGIS itself: mgis_load LIBRARY BEHAVIOUR HYPOTHESIS... prints what MGIS has read.
//
// The wheel of OpenGeoSys has the library of MGIS without its headers. What is called of it is declared here; `load`
// makes all checks of MGIS and throws an exception with the reason if a behaviour is not accepted.
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace mgis {
namespace behaviour {
enum struct Hypothesis;
Hypothesis fromString(const char *);
// larger than that of MGIS, whose members are not used; it is returned through memory because of its destructor
struct Behaviour {
  alignas(16) unsigned char members[8192];
  ~Behaviour() {}
};
Behaviour load(const std::string &library, const std::string &behaviour, Hypothesis);
} // namespace behaviour

struct LibrariesManager {
  using Text = const std::string &;
  using Hypothesis = behaviour::Hypothesis;
  static LibrariesManager &get();
  std::vector<std::string> getGradientsNames(Text, Text, Hypothesis);
  std::vector<std::string> getMaterialPropertiesNames(Text, Text, Hypothesis);
  std::vector<std::string> getInternalStateVariablesNames(Text, Text, Hypothesis);
  std::vector<std::string> getExternalStateVariablesNames(Text, Text, Hypothesis);
  bool hasLowerPhysicalBound(Text, Text, Hypothesis, Text);
  bool hasUpperPhysicalBound(Text, Text, Hypothesis, Text);
  long double getLowerPhysicalBound(Text, Text, Hypothesis, Text);
  long double getUpperPhysicalBound(Text, Text, Hypothesis, Text);
};
} // namespace mgis

int main(int count, char **arguments) {
  if (count < 4 || count % 2 != 0) {
    std::cerr << "expected LIBRARY, then pairs of BEHAVIOUR and HYPOTHESIS\n";
    return EXIT_FAILURE;
  }
  auto &manager = mgis::LibrariesManager::get();
  const std::string library = arguments[1];
  std::cout.precision(17);
  try {
    for (int i = 2; i < count; i += 2) {
      const std::string name = arguments[i];
      const auto hypothesis = mgis::behaviour::fromString(arguments[i + 1]);
      mgis::behaviour::load(library, name, hypothesis);
      std::cout << name << ' ' << arguments[i + 1];
      for (const auto &one : manager.getGradientsNames(library, name, hypothesis)) std::cout << ' ' << one;
      for (const auto &one : manager.getMaterialPropertiesNames(library, name, hypothesis)) {
        std::cout << ' ' << one;
        if (manager.hasLowerPhysicalBound(library, name, hypothesis, one))
          std::cout << ">=" << manager.getLowerPhysicalBound(library, name, hypothesis, one);
        if (manager.hasUpperPhysicalBound(library, name, hypothesis, one))
          std::cout << "<=" << manager.getUpperPhysicalBound(library, name, hypothesis, one);
      }
      for (const auto &one : manager.getInternalStateVariablesNames(library, name, hypothesis)) std::cout << ' ' << one;
      for (const auto &one : manager.getExternalStateVariablesNames(library, name, hypothesis)) std::cout << ' ' << one;
      std::cout << '\n';
    }
  } catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return EXIT_FAILURE;
  }
}
