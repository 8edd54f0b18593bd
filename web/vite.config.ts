import { defineConfig } from "vitest/config";

export default defineConfig({
  build: {
    // three.js is most of the page, and one file of its own that browsers keep.
    chunkSizeWarningLimit: 900,
    // The studio's content policy allows no data: scripts or styles.
    assetsInlineLimit: 0,
  },
  test: {
    include: ["src/**/*.test.ts"],
  },
});
