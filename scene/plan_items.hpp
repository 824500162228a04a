// What a plan says to people: each thing that could be built, whether it is, and why.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace afferent {

struct PlanItem {
    std::string name;
    bool built;
    std::string reason;
};

class PlanItems {
  public:
    void add(std::string name, bool built, std::string reason) {
        items_.push_back({std::move(name), built, std::move(reason)});
    }
    std::vector<PlanItem> take() { return std::move(items_); }

  private:
    std::vector<PlanItem> items_;
};

// "12.5", without zeros at its end.
std::string decimal(double value);

}  // namespace afferent
