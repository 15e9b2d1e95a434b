#include "mapping/store/image_codec.hpp"

#include <cpl_vsi.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "calib/base/error.hpp"
#include "mapping/store/gdal_support.hpp"

namespace ceilmap::store {
namespace {

std::uint32_t BigEndian32(const unsigned char* bytes) {
  return static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
         static_cast<std::uint32_t>(bytes[2]) << 8 | static_cast<std::uint32_t>(bytes[3]);
}

bool HeaderSays(const std::vector<unsigned char>& png, cv::Size size) {
  // Signature (8), length and name of the first chunk (8), then width and height.
  constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::size_t kHeaderBytes = 24;
  return png.size() >= kHeaderBytes &&
         std::equal(kSignature.begin(), kSignature.end(), png.begin()) &&
         BigEndian32(&png[16]) == static_cast<std::uint32_t>(size.width) &&
         BigEndian32(&png[20]) == static_cast<std::uint32_t>(size.height);
}

/// Bytes as a file for GDAL, without a copy. The name is that of the bytes' address: unique while
/// they live.
class MemoryFile {
 public:
  explicit MemoryFile(const std::vector<unsigned char>& bytes)
      : name_("/vsimem/ceilmap/" + std::to_string(reinterpret_cast<std::uintptr_t>(bytes.data())) +
              ".png") {
    // GDAL takes a pointer to mutable bytes but only reads a file opened for reading.
    VSIFCloseL(VSIFileFromMemBuffer(
        name_.c_str(), const_cast<unsigned char*>(bytes.data()), bytes.size(), FALSE));
  }
  ~MemoryFile() { VSIUnlink(name_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] const char* Name() const { return name_.c_str(); }

 private:
  std::string name_;
};

}  // namespace

std::vector<unsigned char> EncodeImage(const cv::Mat& image) {
  std::vector<unsigned char> png;
  // Without parameters OpenCV takes its fastest setting (run lengths of row differences).
  if (!cv::imencode(".png", image, png)) throw RunError("cannot encode an image as PNG");
  return png;
}

cv::Mat DecodeImage(const std::vector<unsigned char>& png, cv::Size size) {
  if (!HeaderSays(png, size)) {
    throw InputError("a stored image is no PNG of the size that the map names");
  }
  // By GDAL rather than OpenCV, whose PNG reader prints on damaged data.
  const GdalScope gdal;
  const GdalOption no_search("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
  const GdalOption no_aux("GDAL_PAM_ENABLED", "NO");
  const MemoryFile file(png);
  const std::array<const char*, 2> drivers = {"PNG", nullptr};
  const GDALDatasetUniquePtr dataset(
      GDALDataset::Open(file.Name(), GDAL_OF_RASTER, drivers.data(), nullptr, nullptr));
  cv::Mat image;
  if (dataset && dataset->GetRasterCount() == 1 && dataset->GetRasterXSize() == size.width &&
      dataset->GetRasterYSize() == size.height) {
    image.create(size, CV_8UC1);
    const CPLErr error = dataset->GetRasterBand(1)->RasterIO(GF_Read,
                                                             0,
                                                             0,
                                                             size.width,
                                                             size.height,
                                                             image.data,
                                                             size.width,
                                                             size.height,
                                                             GDT_Byte,
                                                             1,
                                                             static_cast<GSpacing>(image.step),
                                                             nullptr);
    if (error != CE_None) image.release();
  }
  if (image.empty() || gdal.Failed()) {
    throw InputError("a stored image is damaged (" + gdal.Message() + ")");
  }
  return image;
}

}  // namespace ceilmap::store
