//! The STM32F429ZI as this bench describes it: where each instance the firmware uses answers, what
//! it answers behind, and what runs on which clock. Everything else of the part is not there, and
//! an access to it stops the run.
//!
//! Addresses are those of RM0090 section 2.3, interrupt positions those of table 63, clock enables
//! and resets those of sections 6.3.5 to 6.3.14, DMA requests those of tables 43 and 44, and reset
//! values those of the register descriptions named beside them. The register layouts themselves
//! are the vendor's, generated into `rigless`.
use std::num::{NonZeroU32, NonZeroU64};

use rigless::soc::st::dma::{Reach, Requests, Span, Wire};
use rigless::soc::stm32f427::generated::{
    can1, dbg, dma2, flash, gpioa, i2c3, iwdg, pwr, rcc, spi1, tim2, usart6,
};
use rigless::soc::stm32f427::peripherals::flash as flash_fields;
use rigless::soc::stm32f427::peripherals::{i2c, rcc as tree, spi, usart};
use rigless::soc::{
    Bus, Clock, Cpu, Endian, EraseBlocks, Error, Gate, Peripheral, Region, RegisterSpec,
    WriteModify,
};

/// The first byte of bank 1.
pub(crate) const FLASH_BASE: u64 = 0x0800_0000;
/// Both banks.
pub(crate) const FLASH_LEN: usize = 2 << 20;
/// The first byte of bank 2.
pub(crate) const BANK_2: u64 = FLASH_BASE + (1 << 20);
/// Core-coupled memory: data for the core alone, no DMA controller reaches it (RM0090 2.3.1).
pub(crate) const CCM_BASE: u64 = 0x1000_0000;
/// 64 KB.
pub(crate) const CCM_LEN: u64 = 64 << 10;
/// SRAM1 to SRAM3.
pub(crate) const SRAM_BASE: u64 = 0x2000_0000;
/// 192 KB.
pub(crate) const SRAM_LEN: u64 = 192 << 10;
/// The 96-bit unique device ID (RM0090 section 39.1).
pub(crate) const UNIQUE_ID: u64 = 0x1FFF_7A10;
/// The flash size in KB (RM0090 section 39.2).
pub(crate) const FLASH_SIZE: u64 = 0x1FFF_7A22;
/// Stream registers of both controllers: from the first to past the last.
pub(crate) const DMA: std::ops::Range<u64> = 0x4002_6000..0x4002_6800;

/// The region the core boots from: BOOT0 is low on the board.
pub(crate) const BOOT_REGION: &str = "flash";

/// External interrupt positions, 0 to 90.
const INTERRUPT_LINES: u16 = 91;

static MEMORY: [Region; 4] = [
    Region::flash(BOOT_REGION, FLASH_BASE, FLASH_LEN as u64)
        .erased_in(&SECTORS)
        .erased_to(0xFF)
        .programmed_by("FLASH"),
    Region::ram("ccm", CCM_BASE, CCM_LEN),
    Region::system("system", 0x1FFF_0000, 32 << 10),
    Region::ram("sram", SRAM_BASE, SRAM_LEN),
];

/// Twice four sectors of 16 KB, one of 64 KB and seven of 128 KB (RM0090 table 6).
static SECTORS: [EraseBlocks; 6] = [
    sectors(16, 4),
    sectors(64, 1),
    sectors(128, 7),
    sectors(16, 4),
    sectors(64, 1),
    sectors(128, 7),
];

const fn sectors(kilobytes: u64, count: u32) -> EraseBlocks {
    match (NonZeroU64::new(kilobytes << 10), NonZeroU32::new(count)) {
        (Some(size), Some(count)) => EraseBlocks { size, count },
        _ => panic!("a sector has bytes"),
    }
}

/// The ports with a pin on the LQFP144 package that the boards use, and those between them.
pub(crate) const PORTS: [&str; 9] =
    ["GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE", "GPIOF", "GPIOG", "GPIOH", "GPIOI"];

const BLOCK: u64 = 0x400;

#[rustfmt::skip]
static INSTANCES: [(&str, u64, &[u16], &[RegisterSpec]); 21] = [
    ("TIM5",   0x4000_0C00, &[50],                              &tim2::REGISTERS),
    ("IWDG",   0x4000_3000, &[],                                &iwdg::REGISTERS),
    ("USART2", 0x4000_4400, &[38],                              &usart6::REGISTERS),
    ("I2C1",   0x4000_5400, &[31, 32],                          &i2c3::REGISTERS),
    ("CAN1",   0x4000_6400, &[19, 20, 21, 22],                  &can1::REGISTERS),
    ("PWR",    0x4000_7000, &[1],                               &pwr::REGISTERS),
    ("SPI1",   0x4001_3000, &[35],                              &spi1::REGISTERS),
    ("GPIOA",  0x4002_0000, &[],                                &gpioa::REGISTERS),
    ("GPIOB",  0x4002_0400, &[],                                &gpioa::REGISTERS),
    ("GPIOC",  0x4002_0800, &[],                                &gpioa::REGISTERS),
    ("GPIOD",  0x4002_0C00, &[],                                &gpioa::REGISTERS),
    ("GPIOE",  0x4002_1000, &[],                                &gpioa::REGISTERS),
    ("GPIOF",  0x4002_1400, &[],                                &gpioa::REGISTERS),
    ("GPIOG",  0x4002_1800, &[],                                &gpioa::REGISTERS),
    ("GPIOH",  0x4002_1C00, &[],                                &gpioa::REGISTERS),
    ("GPIOI",  0x4002_2000, &[],                                &gpioa::REGISTERS),
    ("RCC",    0x4002_3800, &[5],                               &rcc::REGISTERS),
    ("FLASH",  0x4002_3C00, &[4],                               &flash::REGISTERS),
    ("DMA1",   0x4002_6000, &[11, 12, 13, 14, 15, 16, 17, 47],  &dma2::REGISTERS),
    ("DMA2",   0x4002_6400, &[56, 57, 58, 59, 60, 68, 69, 70],  &dma2::REGISTERS),
    // DBGMCU: the HAL keeps the debug clock running in sleep. Plain storage, as without a probe.
    ("DBG",    0xE004_2000, &[],                                &dbg::REGISTERS),
];

/// Each instance's clock enable and reset, by register and field: (instance, enable register,
/// enable, reset register, reset).
#[rustfmt::skip]
const CLOCKED: [(&str, &str, &str, &str, &str); 17] = [
    ("TIM5",   "APB1ENR", "TIM5EN",   "APB1RSTR", "TIM5RST"),
    ("USART2", "APB1ENR", "USART2EN", "APB1RSTR", "UART2RST"),
    ("I2C1",   "APB1ENR", "I2C1EN",   "APB1RSTR", "I2C1RST"),
    ("CAN1",   "APB1ENR", "CAN1EN",   "APB1RSTR", "CAN1RST"),
    ("PWR",    "APB1ENR", "PWREN",    "APB1RSTR", "PWRRST"),
    ("SPI1",   "APB2ENR", "SPI1EN",   "APB2RSTR", "SPI1RST"),
    ("GPIOA",  "AHB1ENR", "GPIOAEN",  "AHB1RSTR", "GPIOARST"),
    ("GPIOB",  "AHB1ENR", "GPIOBEN",  "AHB1RSTR", "GPIOBRST"),
    ("GPIOC",  "AHB1ENR", "GPIOCEN",  "AHB1RSTR", "GPIOCRST"),
    ("GPIOD",  "AHB1ENR", "GPIODEN",  "AHB1RSTR", "GPIODRST"),
    ("GPIOE",  "AHB1ENR", "GPIOEEN",  "AHB1RSTR", "GPIOERST"),
    ("GPIOF",  "AHB1ENR", "GPIOFEN",  "AHB1RSTR", "GPIOFRST"),
    ("GPIOG",  "AHB1ENR", "GPIOGEN",  "AHB1RSTR", "GPIOGRST"),
    ("GPIOH",  "AHB1ENR", "GPIOHEN",  "AHB1RSTR", "GPIOHRST"),
    ("GPIOI",  "AHB1ENR", "GPIOIEN",  "AHB1RSTR", "GPIOIRST"),
    ("DMA1",   "AHB1ENR", "DMA1EN",   "AHB1RSTR", "DMA1RST"),
    ("DMA2",   "AHB1ENR", "DMA2EN",   "AHB1RSTR", "DMA2RST"),
];

/// The clock tree's output each instance counts on (RM0090 figure 16).
#[rustfmt::skip]
const RUNS_ON: [(&str, usize); 7] = [
    ("TIM5",   tree::APB1_TIMERS),
    ("USART2", tree::PCLK1),
    ("I2C1",   tree::PCLK1),
    ("CAN1",   tree::PCLK1),
    ("SPI1",   tree::PCLK2),
    ("FLASH",  tree::HCLK),
    ("IWDG",   tree::IWDG_CLK),
];

/// Reset values the vendor's file gets wrong or gives one instance of several.
#[rustfmt::skip]
const RESET_VALUES: [(&str, &str, u64); 12] = [
    ("USART2", "SR",         0x0000_00C0), // 30.6.1: TXE and TC
    ("SPI1",   "I2SPR",      0x0000_0002), // 28.5.9
    ("TIM5",   "ARR",        0xFFFF_FFFF), // 18.4.12
    ("GPIOA",  "MODER",      0xA800_0000), // 8.4.1: the debug pins
    ("GPIOA",  "OSPEEDR",    0x0C00_0000), // 8.4.3
    ("GPIOA",  "PUPDR",      0x6400_0000), // 8.4.4
    ("GPIOB",  "MODER",      0x0000_0280),
    ("GPIOB",  "OSPEEDR",    0x0000_00C0),
    ("GPIOB",  "PUPDR",      0x0000_0100),
    ("RCC",    "AHB1LPENR",  0x7EEF_97FF), // 6.3.15
    ("RCC",    "APB1LPENR",  0xF6FE_C9FF), // 6.3.18
    ("DBG",    "DBGMCU_IDCODE", 0x2003_6419), // 38.6.1: this family, revision 4, 5 or B
];

/// Requests that reach a stream of DMA1 (table 43).
#[rustfmt::skip]
static DMA1_REQUESTS: [Wire; 4] = [
    Wire { instance: "I2C1",   request: i2c::RECEIVE_REQUEST,    channel: 1, streams: &[0, 5] },
    Wire { instance: "I2C1",   request: i2c::TRANSMIT_REQUEST,   channel: 1, streams: &[6, 7] },
    Wire { instance: "USART2", request: usart::RECEIVE_REQUEST,  channel: 4, streams: &[5] },
    Wire { instance: "USART2", request: usart::TRANSMIT_REQUEST, channel: 4, streams: &[6] },
];

/// Requests that reach a stream of DMA2 (table 44).
#[rustfmt::skip]
static DMA2_REQUESTS: [Wire; 2] = [
    Wire { instance: "SPI1", request: spi::RECEIVE_REQUEST,  channel: 3, streams: &[0, 2] },
    Wire { instance: "SPI1", request: spi::TRANSMIT_REQUEST, channel: 3, streams: &[3, 5] },
];

/// What no DMA controller reaches.
const BEYOND_DMA: &[Span] = &[Span { base: CCM_BASE, bytes: CCM_LEN }];

/// The wiring of a DMA controller, by its position in DMA1, DMA2. Only DMA2's peripheral port
/// reaches memory (RM0090 figure 34).
pub(crate) fn dma(controller: usize) -> (Requests, Reach) {
    let wiring: &'static [Wire] = if controller == 0 { &DMA1_REQUESTS } else { &DMA2_REQUESTS };
    (
        Requests::Channels { wiring, last_data: &[], select: dma2::s0cr::CHSEL },
        Reach { memory_to_memory: controller != 0, unreachable: BEYOND_DMA },
    )
}

/// The bus with every instance, none of them with a model yet.
///
/// # Errors
/// When the description contradicts itself.
pub(crate) fn bus() -> Result<Bus, Error> {
    let cpu = Cpu::new("Cortex-M4", true, INTERRUPT_LINES, Endian::Little);
    let instances = INSTANCES.iter().map(|&(name, base, interrupts, registers)| Peripheral {
        name,
        base,
        size: BLOCK,
        interrupts,
        registers,
    });
    let mut builder = Bus::builder(cpu, &MEMORY, instances);
    for (instance, register, value) in RESET_VALUES {
        builder = builder.reset(instance, register, value);
    }
    for port in PORTS.iter().skip(2) {
        for register in ["MODER", "OSPEEDR", "PUPDR"] {
            builder = builder.reset(port, register, 0);
        }
    }
    for (instance, enable_register, enable, reset_register, reset) in CLOCKED {
        builder = builder
            .gate(instance, Gate::by("RCC", enable_register, enable))
            .reset_by(instance, Gate::by("RCC", reset_register, reset));
    }
    for (instance, output) in RUNS_ON {
        builder = builder.clocked_by(instance, Clock::output("RCC", output));
    }
    for reader in ["RCC", "DMA1", "DMA2"] {
        builder = builder.reads_requests(reader);
    }
    // Write rules the vendor's file leaves out: 18.4.5, 27.6.6, 3.9.6, 3.9.8, 3.9.10, 5.5.1.
    builder
        .write_modify("TIM5", "SR", WriteModify::ZeroToClear)
        .write_modify("I2C1", "SR1", WriteModify::ZeroToClear)
        .write_modify("FLASH", "SR", WriteModify::OneToClear)
        .field("FLASH", "ACR", "LATENCY", flash_fields::LATENCY)
        .field("FLASH", "CR", "LOCK", flash_fields::LOCK)
        .field("FLASH", "CR", "STRT", flash_fields::STRT)
        .field("FLASH", "OPTCR", "OPTLOCK", flash_fields::OPTLOCK)
        .field("FLASH", "OPTCR", "OPTSTRT", flash_fields::OPTSTRT)
        .declare("FLASH", "SR", &flash_fields::RDERR)
        .gate_writes("RCC", &["BDCR"], Gate::by("PWR", "CR", "DBP"))
        .build()
}
