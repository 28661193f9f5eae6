#include "core/image/codecs.h"

// clang-format off
#include <gtest/gtest.h>
#include <png.h>
#include <webp/encode.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include <jpeglib.h>  // needs size_t and FILE
// clang-format on

namespace lightbatch::image {
namespace {

Image8 test_image(int width, int height) {
  Image8 image;
  image.width = width;
  image.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {x * 7 + y, x * y, 255 - x, 128 + y}) {
        image.rgba.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  return image;
}

Bytes jpeg_of(const Image8& image) {
  jpeg_compress_struct info{};
  jpeg_error_mgr errors{};
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &out, &size);
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = 4;
  info.in_color_space = JCS_EXT_RGBA;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 98, TRUE);
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    std::vector<std::uint8_t> row(
        image.pixel(0, static_cast<int>(info.next_scanline)),
        image.pixel(0, static_cast<int>(info.next_scanline)) + 4 * image.width);
    JSAMPROW rows = row.data();
    jpeg_write_scanlines(&info, &rows, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const auto* first = reinterpret_cast<const std::byte*>(out);
  Bytes bytes(first, first + size);
  std::free(out);
  return bytes;
}

Bytes webp_of(const Image8& image) {
  std::uint8_t* out = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGBA(image.rgba.data(), image.width, image.height, 4 * image.width, &out);
  const auto* first = reinterpret_cast<const std::byte*>(out);
  Bytes bytes(first, first + size);
  WebPFree(out);
  return bytes;
}

TEST(Png, RoundTripsEveryPixel) {
  const Image8 image = test_image(37, 19);
  const Bytes bytes = encode_png(image, true);
  EXPECT_EQ(detect_format(bytes), Format::kPng);
  const auto decoded = decode_image8(bytes, "test.png");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  EXPECT_EQ(decoded->width, 37);
  EXPECT_EQ(decoded->height, 19);
  EXPECT_EQ(decoded->rgba, image.rgba);
}

TEST(Png, WithoutAlphaKeepsColourAndIsOpaque) {
  const Image8 image = test_image(5, 7);
  const auto decoded = decode_image8(encode_png(image, false), "test.png");
  ASSERT_TRUE(decoded.ok());
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    EXPECT_EQ(decoded->rgba[i], i % 4 == 3 ? 255 : image.rgba[i]) << i;
  }
}

TEST(Png, SamePixelsGiveSameBytes) {
  const Image8 image = test_image(64, 64);
  EXPECT_EQ(encode_png(image, true), encode_png(image, true));
}

TEST(Png, EveryTruncationIsRefused) {
  const Bytes bytes = encode_png(test_image(9, 5), true);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto decoded = decode_image8(std::span(bytes).first(size), "cut.png");
    EXPECT_FALSE(decoded.ok()) << size;
  }
}

TEST(Png, DamagedBytesNeverCrash) {
  const Bytes bytes = encode_png(test_image(9, 5), true);
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    Bytes damaged = bytes;
    damaged[i] ^= std::byte{0x55};
    const auto decoded = decode_image8(damaged, "damaged.png");
    if (decoded.ok()) {
      EXPECT_EQ(decoded->rgba.size(), 4u * 9u * 5u);
    }
  }
}

TEST(Decode, LargeHeaderIsRefusedBeforeAllocation) {
  // A PNG header that claims 60000 x 60000 pixels: 14 GiB if believed.
  Bytes bytes = encode_png(test_image(4, 4), true);
  for (const std::size_t at : {16u, 20u}) {
    bytes[at + 2] = std::byte{0xea};
    bytes[at + 3] = std::byte{0x60};
  }
  // The checksum of the header is wrong now; libpng says so, or the size check does.
  EXPECT_FALSE(decode_image8(bytes, "bomb.png").ok());
  const auto refused = decode_image8(encode_png(test_image(40, 40), true), "large.png", 1599);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().reason(), "INPUT_OVER_BUDGET");
  EXPECT_EQ(refused.status().place(), "large.png");
}

TEST(Jpeg, DecodesCloseToTheOriginal) {
  Image8 image = test_image(32, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) {
      std::uint8_t* pixel = image.rgba.data() + 4 * (y * 32 + x);
      pixel[0] = static_cast<std::uint8_t>(x * 8);
      pixel[1] = static_cast<std::uint8_t>(y * 8);
      pixel[2] = 100;
    }
  }
  const auto decoded = decode_image8(jpeg_of(image), "test.jpg");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  ASSERT_EQ(decoded->width, 32);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    // Smooth ramps at quality 98 with halved chroma: a few steps of 255.
    const int expected = i % 4 == 3 ? 255 : image.rgba[i];
    EXPECT_NEAR(decoded->rgba[i], expected, 6) << i;
  }
}

TEST(Size, IsReadFromHeadersAlone) {
  const Image8 image = test_image(37, 19);
  for (const Bytes& bytes : {encode_png(image, true), jpeg_of(image), webp_of(image)}) {
    // A cut file still has its size, as long as the header is there.
    const auto size = read_image8_size(std::span(bytes).first(bytes.size() * 3 / 4), "x");
    ASSERT_TRUE(size.ok()) << size.status().to_string();
    EXPECT_EQ(size->width, 37);
    EXPECT_EQ(size->height, 19);
    EXPECT_EQ(size->pixels(), 37u * 19u);
    for (std::size_t cut = 0; cut < 12; ++cut) {
      EXPECT_FALSE(read_image8_size(std::span(bytes).first(cut), "x").ok());
    }
  }
  EXPECT_FALSE(read_image8_size(as_bytes("GIF89a"), "x").ok());
}

/// Writes a PNG of the colour type and depth given; `rows` as libpng wants them.
Bytes raw_png(int width, int height, int depth, int type, bool interlaced,
              std::vector<std::vector<png_byte>> rows) {
  Bytes bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp writer, png_bytep data, std::size_t count) {
        auto* out = static_cast<Bytes*>(png_get_io_ptr(writer));
        const auto* first = reinterpret_cast<const std::byte*>(data);
        out->insert(out->end(), first, first + count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), depth,
               type, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  const png_color palette[2] = {{10, 20, 30}, {40, 50, 60}};
  if (type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 2);
  png_set_gAMA(png, info, 0.2);  // must be ignored
  png_write_info(png, info);
  std::vector<png_bytep> pointers;
  for (auto& row : rows) pointers.push_back(row.data());
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

TEST(Png, EveryKindBecomesRgba) {
  const auto pixel = [](const Bytes& bytes, int x, int y) {
    const auto image = decode_image8(bytes, "x.png");
    EXPECT_TRUE(image.ok()) << image.status().to_string();
    if (!image.ok()) return std::vector<int>{};
    const std::uint8_t* p = image->pixel(x, y);
    return std::vector<int>{p[0], p[1], p[2], p[3]};
  };
  const Bytes grey = raw_png(2, 1, 8, PNG_COLOR_TYPE_GRAY, false, {{7, 200}});
  EXPECT_EQ(pixel(grey, 1, 0), (std::vector<int>{200, 200, 200, 255}));
  const Bytes bits = raw_png(2, 1, 1, PNG_COLOR_TYPE_GRAY, false, {{0x40}});
  EXPECT_EQ(pixel(bits, 0, 0), (std::vector<int>{0, 0, 0, 255}));
  EXPECT_EQ(pixel(bits, 1, 0), (std::vector<int>{255, 255, 255, 255}));
  const Bytes palette = raw_png(2, 1, 1, PNG_COLOR_TYPE_PALETTE, false, {{0x40}});
  EXPECT_EQ(pixel(palette, 1, 0), (std::vector<int>{40, 50, 60, 255}));
  const Bytes deep =
      raw_png(1, 1, 16, PNG_COLOR_TYPE_GRAY_ALPHA, false, {{0x80, 0x80, 0xff, 0xff}});
  EXPECT_EQ(pixel(deep, 0, 0), (std::vector<int>{128, 128, 128, 255}));
  std::vector<std::vector<png_byte>> rows;
  for (int y = 0; y < 9; ++y) {
    rows.emplace_back();
    for (int x = 0; x < 11; ++x) {
      for (const int value : {x, y, x + y}) rows.back().push_back(static_cast<png_byte>(value));
    }
  }
  const Bytes interlaced = raw_png(11, 9, 8, PNG_COLOR_TYPE_RGB, true, rows);
  EXPECT_EQ(pixel(interlaced, 10, 8), (std::vector<int>{10, 8, 18, 255}));
  EXPECT_EQ(pixel(interlaced, 3, 5), (std::vector<int>{3, 5, 8, 255}));
}

TEST(Jpeg, TruncationIsRefused) {
  const Bytes bytes = jpeg_of(test_image(32, 32));
  for (std::size_t size = 0; size + 2 < bytes.size(); size += 3) {
    EXPECT_FALSE(decode_image8(std::span(bytes).first(size), "cut.jpg").ok()) << size;
  }
}

TEST(Webp, LosslessRoundTripsAndTruncationIsRefused) {
  Image8 image = test_image(21, 13);
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    image.rgba[i] |= 1;  // no fully clear pixel
  const Bytes bytes = webp_of(image);
  const auto decoded = decode_image8(bytes, "test.webp");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  EXPECT_EQ(decoded->rgba, image.rgba);
  for (std::size_t size = 0; size < bytes.size() - 8; size += 5) {
    EXPECT_FALSE(decode_image8(std::span(bytes).first(size), "cut.webp").ok()) << size;
  }
}

TEST(Decode, OtherFormatsAreNamed) {
  const std::string ktx = std::string("\xabKTX 20\xbb\r\n\x1a\n", 12) + std::string(64, '\0');
  EXPECT_EQ(detect_format(as_bytes(ktx)), Format::kKtx2);
  EXPECT_EQ(decode_image8(as_bytes(ktx), "t.ktx2").status().reason(), "INPUT_UNSUPPORTED");
  EXPECT_EQ(decode_image8(as_bytes("GIF89a........"), "t.gif").status().reason(),
            "INPUT_UNSUPPORTED");
  EXPECT_EQ(decode_image8({}, "empty").status().reason(), "INPUT_MALFORMED");
  EXPECT_EQ(decode_image_rgb(encode_png(test_image(2, 2), true), "sky.png").status().reason(),
            "INPUT_UNSUPPORTED");
}

TEST(Exr, HalfRoundTripsWithinHalfPrecision) {
  ImageRgb image(33, 9);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 33; ++x) {
      image.at(x, y) = {static_cast<float>(x) * 0.37f, static_cast<float>(y) * 1.9f + 0.001f,
                        std::exp(static_cast<float>(x) * 0.3f)};
    }
  }
  image.at(3, 3) = {65504.0f, -65504.0f, 0.0f};  // the largest of half
  std::vector<float> alpha(image.pixels.size(), 0.25f);
  const auto bytes = encode_exr(image, alpha);
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(*bytes, *encode_exr(image, alpha));
  EXPECT_EQ(detect_format(*bytes), Format::kExr);
  const auto decoded = decode_image_rgb(*bytes, "page.exr");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  ASSERT_EQ(decoded->width, 33);
  ASSERT_EQ(decoded->height, 9);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (const auto& [want, got] : {std::pair{image.pixels[i].r, decoded->pixels[i].r},
                                    std::pair{image.pixels[i].g, decoded->pixels[i].g},
                                    std::pair{image.pixels[i].b, decoded->pixels[i].b}}) {
      // Half has 11 significant bits: half a unit of the last one.
      EXPECT_NEAR(got, want, std::abs(want) * 0x1p-11f + 1e-7f);
    }
  }
  EXPECT_FALSE(encode_exr(image, std::vector<float>(3)).ok());
}

TEST(Exr, FloatWhereHalfDoesNotReach) {
  ImageRgb image(5, 2);
  image.at(1, 0) = {100'000.0f, 65504.0f, 1e-9f};
  image.at(4, 1) = {0.1f, 3e30f, 65505.0f};
  const auto bytes = encode_exr(image, {});
  ASSERT_TRUE(bytes.ok());
  const auto decoded = decode_image_rgb(*bytes, "sun.exr");
  ASSERT_TRUE(decoded.ok()) << decoded.status().to_string();
  EXPECT_EQ(decoded->pixels, image.pixels);
}

TEST(Exr, DimLightKeepsItsDigits) {
  ImageRgb image(40, 40);
  std::vector<float> alpha(image.pixels.size(), 1.0f);
  const auto worst_of = [&] {
    const auto back = decode_image_rgb(*encode_exr(image, alpha), "dim.exr");
    double worst = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const double is = static_cast<double>(image.pixels[i].r);
      if (is > 0)
        worst = std::max(worst, std::fabs(static_cast<double>(back->pixels[i].r) / is - 1));
    }
    return worst;
  };
  for (const float scale : {1e-3f, 3e-5f, 1e-6f, 1e-9f, 1e-20f}) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      image.pixels[i] = Rgb::grey(scale * (1 + static_cast<float>(i) / 1600));
    }
    EXPECT_LT(worst_of(), 1e-3) << scale;
  }
  // A dark room on the page of a bright one.
  for (std::size_t i = 10; i < image.pixels.size(); ++i) image.pixels[i] = Rgb::grey(100);
  EXPECT_LT(worst_of(), 1e-3);
  // A few dim texels, or what is covered by none, do not double the file.
  const auto random_page = [&](std::size_t dim) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const auto bits = static_cast<float>((i * 2654435761u) % 1048573u) / 1048573.0f;
      image.pixels[i] = Rgb::grey(i < dim ? 1e-6f : 1 + bits);
    }
  };
  random_page(1);
  const std::size_t half_size = encode_exr(image, alpha)->size();
  random_page(100);
  const std::size_t float_size = encode_exr(image, alpha)->size();
  EXPECT_GT(static_cast<double>(float_size), 1.2 * static_cast<double>(half_size));
  for (std::size_t i = 0; i < 100; ++i) alpha[i] = 0;
  EXPECT_LT(static_cast<double>(encode_exr(image, alpha)->size()),
            1.1 * static_cast<double>(half_size));
}

TEST(Exr, LayersRoundTripExactly) {
  std::vector<ExrLayer> layers{{"light_0", ImageRgb(3, 2)}, {"sky", ImageRgb(3, 2)}};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = static_cast<float>(i);
    layers[0].image.pixels[i] = {value / 3, 1e6f * value, -value};
    layers[1].image.pixels[i] = {7, value, 0};
  }
  const auto bytes = encode_exr_layers(layers);
  ASSERT_TRUE(bytes.ok());
  const auto back = decode_exr_layers(*bytes, "layers.exr");
  ASSERT_TRUE(back.ok()) << back.status().to_string();
  ASSERT_EQ(back->size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ((*back)[k].name, layers[k].name);
    EXPECT_EQ((*back)[k].image.pixels, layers[k].image.pixels);
  }
  EXPECT_FALSE(decode_exr_layers(*bytes, "layers.exr", 5).ok());
  layers[1].image = ImageRgb(2, 2);
  EXPECT_FALSE(encode_exr_layers(layers).ok());
  for (std::size_t size = 0; size < bytes->size(); size += 7) {
    EXPECT_FALSE(decode_exr_layers(std::span(*bytes).first(size), "cut.exr").ok()) << size;
  }
}

TEST(Exr, AlphaIsRead) {
  const ImageRgb image(2, 2);
  const std::vector<float> alpha{0, 0.25f, 0.5f, 1};
  const auto read = decode_exr_alpha(*encode_exr(image, alpha), "alpha.exr");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(*read, alpha);
}

TEST(Exr, TruncationAndDamageNeverCrash) {
  const auto bytes = encode_exr(ImageRgb(8, 8), {});
  ASSERT_TRUE(bytes.ok());
  for (std::size_t size = 0; size + 1 < bytes->size(); ++size) {
    EXPECT_FALSE(decode_image_rgb(std::span(*bytes).first(size), "cut.exr").ok()) << size;
  }
  for (std::size_t i = 4; i < bytes->size(); ++i) {
    Bytes damaged = *bytes;
    damaged[i] ^= std::byte{0x81};
    const auto decoded = decode_image_rgb(damaged, "damaged.exr", 1 << 20);
    if (decoded.ok()) {
      EXPECT_LE(decoded->pixels.size(), 1u << 20);
    }
  }
}

}  // namespace
}  // namespace lightbatch::image
